// Wide craters as changes from the anchor, in float: as exact as the offset from it. What a crater is, its place above
// the sphere, width, wear and hash, is the same from everywhere: along the ground only the distance from its middle
// changes. Statement by statement as terrain/craters.glsl; d_ stands for changes, as in terrain/height_change.glsl.

// The larger of 0 and y, rounded within `width`; and its share of y. Its change where y changes by d.
float crater_larger(float y, float width, out float share) {
    share = clamp(0.5 + 0.5 * y / width, 0.0, 1.0);
    return y * share + width * share * (1.0 - share);
}

float crater_larger_change(float y, float d, float width, out float new_share) {
    float s = 0.5 + 0.5 * y / width, share = clamp(s, 0.0, 1.0);
    float d_share = terrain_clamp_change(s, 0.5 * d / width, 0.0, 1.0);
    new_share = share + d_share;
    return d * new_share + d_share * (y + width * (1.0 - 2.0 * share - d_share));
}

struct CraterProfile {
    float value, change;  // by the crater's radius: at q, and from there on
    float slope;          // by q, at the new q
    float left;           // at the new q: 0 where the ejecta end
};

CraterProfile crater_profile(CraterShape shape, float fresh, float q, float d) {
    float top = max(1.0 - CRATER_PEAK_NARROW * q, 0.0);
    float d_top = terrain_positive_change(1.0 - CRATER_PEAK_NARROW * q, -CRATER_PEAK_NARROW * d);
    float bottom = shape.rim - shape.bottom + shape.peak * top * top;
    float d_bottom = shape.peak * d_top * (2.0 * top + d_top);
    float over = shape.rim + shape.wall * (q - 1.0) - bottom, d_over = shape.wall * d - d_bottom;
    float share, wall_share, inner_share, width = 0.15 * shape.bottom;
    float inside = bottom + crater_larger(over, width, share);
    float d_inside = d_bottom + crater_larger_change(over, d_over, width, wall_share);

    float left = (4.0 - q) * (1.0 / 3.0), d_left = d * (-1.0 / 3.0), new_left = left + d_left;
    float outside = shape.rim * left * left * left;
    float d_outside = shape.rim * d_left * (left * left + left * new_left + new_left * new_left);
    width = shape.rim * (2.2 - 1.6 * fresh);
    float value = outside - crater_larger(outside - inside, width, share);
    float change = d_outside - crater_larger_change(outside - inside, d_outside - d_inside, width, inner_share);

    float by_bottom = -2.0 * CRATER_PEAK_NARROW * shape.peak * (top + d_top);
    float by_inside = by_bottom + (shape.wall - by_bottom) * wall_share;
    float by_outside = -shape.rim * new_left * new_left;
    return CraterProfile(value, change, by_outside + (by_inside - by_outside) * inner_share, new_left);
}

// Metres by which what an octave adds changes from the place `from` of the eight cells at `base` by d, in cells.
// to_foot: from `from` to whichever of both places lies on the sphere, and up: that over the radius. before: metres
// that the octave adds at the first. ground: as terrain_crater_octave, at the second.
float terrain_crater_way(CraterOctave octave, ivec3 base, vec3 from, vec3 d, vec3 to_foot, vec3 up, float spacing_m,
    out float before, out TerrainSources ground) {
    CraterShape shape = octave.shape;
    float width_m = octave.lattice.wavelength_m, curve = width_m / terrain_table.radius_m;
    uvec3 firsts = uvec3(base) * CRATER_STEPS;
    uint first = firsts.x + firsts.y + firsts.z;
    int reached = 0;
    for (int parity = 0; parity < 8; ++parity) {
        ivec3 side = crater_side(base, parity);
        vec3 v = from - vec3(side) - crater_place(crater_hash(first, side)), w = v + d;
        reached |= min(dot(v, v), dot(w, w)) < 0.25001 ? 1 << parity : 0;
    }
    float change = 0.0;
    before = 0.0;
    ground = NO_SOURCES;
    while (reached != 0) {
        ivec3 side = crater_side(base, findLSB(reached));
        uint hash = crater_hash(first, side), draws = crater_mix(hash ^ 0x68bc21ebu);
        reached &= reached - 1;
        vec3 v = from - vec3(side) - crater_place(hash), w = v + d, foot = v + to_foot;
        vec2 u = vec2(draws & 4095u, draws >> 12 & 4095u) * (1.0 / 4096.0);
        float e = dot(foot, foot) * curve - 2.0 * dot(foot, up), root = sqrt(1.0 + e * curve), z = e / (1.0 + root);
        float depth = max(0.25 - z * z, 1e-9), room = depth / root, kept = clamp(16.0 * room - 1.0, 0.0, 1.0);
        kept = int(draws >> 24) < terrain_table.crater_accept ? kept : 0.0;
        float smaller = 4.0 + 12.0 * u.x, size = sqrt(room / smaller), fresh = kept * (0.15 + 0.85 * u.y * u.y);
        float by_vv = smaller / depth, q = (dot(v, v) - z * z) * by_vv;
        float d_q = terrain_clamp_change(q, dot(d, v + w) * by_vv, 0.0, 4.0);
        q = clamp(q, 0.0, 4.0);
        CraterProfile profile = crater_profile(shape, fresh, q, d_q);
        float within = clamp(1.5 - q - d_q, 0.0, 1.0), cover = kept * terrain_smoothstep(1.5 - q);
        float d_cover = kept * terrain_smoothstep_change(1.5 - q, -d_q), new_cover = cover + d_cover;

        float wide_m = 2.0 * size * width_m, seen = terrain_layer_weight(wide_m, spacing_m);
        float steep = size * fresh * profile.slope
            + (before + change) / width_m * (6.0 * kept * within * (1.0 - within));
        float kept_seen = 1.0 - seen * new_cover;
        ground.gradient = ground.gradient * kept_seen + seen * (2.0 * smaller / (room * root) * steep) * w;
        ground.dug = ground.dug * kept_seen + seen * max(4.0 * fresh - 3.0, 0.0) * min(profile.left, 1.0);

        float shown = terrain_height_weight(wide_m, spacing_m), height_m = shown * fresh * width_m * size;
        change = change * (1.0 - shown * new_cover) - before * (shown * d_cover) + height_m * profile.change;
        before = before * (1.0 - shown * cover) + height_m * profile.value;
    }
    return change;
}

// Metres of an octave at offset D (up: the place over the radius) less those at the anchor.
float terrain_crater_change(CraterOctave octave, vec3 D, vec3 up, float spacing_m, inout TerrainSources ground) {
    TerrainLattice corners = octave.lattice;  // half a cell on: those of the eight cells that reach a place
    vec3 middle = corners.fraction_hi - 0.5, below = vec3(lessThan(middle, vec3(0.0)));
    corners.cell -= ivec3(below);
    corners.fraction_hi = middle + below;
    // Of wide spacings heights do not show all that is at the anchor.
    TerrainWay way = terrain_way(corners, D, spacing_m > octave.lattice.wavelength_m);
    vec3 to_foot = vec3(0.0), foot_up = way.plain ? up : terrain_table.up;
    float change = 0.0, before;
    TerrainSources found;
    do {
        change += terrain_crater_way(octave, way.cell, way.from + 0.5, way.d, to_foot, foot_up, spacing_m, before,
            found);
        way.cell = way.next;
        way.from = way.next_from;
        way.d = to_foot = way.rest;
        foot_up = up;
    } while (--way.parts > 0);
    ground.gradient += found.gradient;
    ground.dug += found.dug;
    return way.plain ? before - octave.lattice.value : change;
}
