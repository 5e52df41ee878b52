// The projected grid: a point of it is two integers, and a function of these alone. float64 side:
// engine/surface/projected_grid.py. Whoever includes it declares the block `paper_grid` before, and frame and planet.

const int PAPER_LEVELS = 7, PAPER_FINEST = 64;

// Foot offset of integer place p: on the reference sphere, metres from the anchor's foot, planet axes.
vec3 paper_foot(ivec2 p) {
    precise vec2 g = vec2(p - paper_grid.half_steps) * paper_grid.per_half;
    precise vec2 g2 = g * g;
    precise vec2 power = paper_grid.power == 4 ? g2 * g2 : g2;
    precise float z = (1.0 - power.x) * (1.0 - power.y) + paper_grid.z_s;
    precise float aside = g2.x + g2.y;
    precise float size = sqrt(aside + z * z);
    // (z - size) / size without cancellation above the equator of the grid.
    precise float fall = z > 0.0 ? -aside / (size * (size + z)) : z / size - 1.0;
    precise vec3 D = planet.radius_m * (g.x / size * paper_grid.first_axis + g.y / size * paper_grid.second_axis
        + fall * paper_grid.third_axis);
    return D + paper_grid.middle_m;
}

// Distance of vertices at D that the size on screen asks for: where a patch is cut into 64 already, what that gives.
float paper_spacing(vec3 D) {
    float away = sqrt(dot(D, D) + paper_grid.proxy_height_m * paper_grid.proxy_height_m);
    return max(paper_grid.smallest_spacing_m, paper_grid.spacing_rad * away);
}

// From the anchor, metres: the point at this height above the anchor's over a foot.
vec3 paper_position(vec3 D, float dh) {
    precise vec3 position = D * (1.0 + (frame.anchor_height_m + dh) / planet.radius_m) + frame.anchor_up * dh;
    return position;
}

// Word of a patch: place, level, and the levels of its four edges i, i + 1, j, j + 1.
ivec2 paper_patch_place(uint word) {
    return ivec2(word & 255u, (word >> 8) & 255u) * PAPER_FINEST;
}

int paper_patch_level(uint word) {
    return int((word >> 16) & 7u);
}

int paper_edge_level(uint word, int edge) {
    return int((word >> (19 + 3 * edge)) & 7u);
}
