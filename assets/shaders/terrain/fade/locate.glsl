// Where a point of the overlay lies among the triangles of one of the two selections: three vertices of a cell and
// their shares. A point on a cell's border gets the same two vertices and shares from either side.
#include "common/cells.glsl"
#include "generated/fade.glsl"

const uint FADE_NONE = 0xffffffffu;

ivec2 fade_masked(uint mask, ivec2 ab) {
    int d_i = ab.x == 0 ? int(mask & 255u) : ab.x == CELL_QUADS ? int((mask >> 8) & 255u) : 0;
    int d_j = ab.y == 0 ? int((mask >> 16) & 255u) : ab.y == CELL_QUADS ? int((mask >> 24) & 255u) : 0;
    return ivec2((ab.x >> d_j) << d_j, (ab.y >> d_i) << d_i);
}

int fade_index(ivec2 ab) {
    return ab.y * CELL_SIDE + ab.x;
}

// p: place in a cell in 2^-finer quads of it; mask, variant: of that cell.
void fade_locate(int finer, uint mask, uint variant, ivec2 p, out ivec3 index, out vec3 share) {
    vec2 x = vec2(p) * exp2(-float(finer));   // exact: a few binary digits
    const float QUADS = float(CELL_QUADS);
    bool on_i = x.x == 0.0 || x.x == QUADS, on_j = x.y == 0.0 || x.y == QUADS;
    if (on_i || on_j) {
        int edge = on_i ? (x.x == 0.0 ? 0 : 1) : (x.y == 0.0 ? 2 : 3);
        int step_size = 1 << int((mask >> (8 * edge)) & 255u);
        float along = on_i ? x.y : x.x;
        int low = int(along) / step_size * step_size, high = min(low + step_size, CELL_QUADS);
        float part = (along - float(low)) / float(step_size);
        ivec2 a = on_i ? ivec2(int(x.x), low) : ivec2(low, int(x.y)),
            b = on_i ? ivec2(int(x.x), high) : ivec2(high, int(x.y));
        index = ivec3(fade_index(a), fade_index(b), fade_index(a));
        share = vec3(1.0 - part, part, 0.0);
        return;
    }
    ivec2 skip = ivec2(int(variant >> 1) / (CELL_MOST + 1), int(variant >> 1) % (CELL_MOST + 1));
    ivec2 size = min(ivec2(1) << skip, ivec2(CELL_QUADS)), count = CELL_QUADS / size;
    ivec2 quad = min(ivec2(x) / size, count - 1), low = quad, high = quad;
    // Along an edge whose vertices are rounded down further, triangles of several quads share a corner.
    int group_i = 1, group_j = 1;
    if (quad.y == 0) group_i = max(group_i, (1 << int((mask >> 16) & 255u)) / size.x);
    if (quad.y == count.y - 1) group_i = max(group_i, (1 << int((mask >> 24) & 255u)) / size.x);
    if (quad.x == 0) group_j = max(group_j, (1 << int(mask & 255u)) / size.y);
    if (quad.x == count.x - 1) group_j = max(group_j, (1 << int((mask >> 8) & 255u)) / size.y);
    low = quad / ivec2(group_i, group_j) * ivec2(group_i, group_j);
    high = min(low + ivec2(group_i, group_j), count) - 1;
    float best = -3.0e38;
    index = ivec3(0);
    share = vec3(1.0, 0.0, 0.0);
    ivec2 n = high - low + 1;
    for (int k = 0; k < n.x * n.y; ++k) {
        ivec2 here = low + ivec2(k % n.x, k / n.x);
        ivec2 a = fade_masked(mask, here * size), b = fade_masked(mask, (here + ivec2(1, 0)) * size);
        ivec2 c = fade_masked(mask, (here + ivec2(0, 1)) * size), d = fade_masked(mask, (here + 1) * size);
        bool falls = (variant & 1u) != 0u && here != count - 1;
        for (int half_quad = 0; half_quad < 2; ++half_quad) {
            ivec2 u = half_quad == 0 ? a : falls ? b : a, v = half_quad == 0 ? b : d,
                w = half_quad == 0 ? (falls ? c : d) : c;
            vec2 e = vec2(v - u), f = vec2(w - u), g = x - vec2(u);
            float area = e.x * f.y - e.y * f.x;
            vec3 s = vec3(0.0, g.x * f.y - g.y * f.x, e.x * g.y - e.y * g.x) / (area == 0.0 ? 1.0 : area);
            s.x = 1.0 - s.y - s.z;
            float least = area == 0.0 ? -3.0e38 : min(s.x, min(s.y, s.z));
            if (least > best) {
                best = least;
                index = ivec3(fade_index(u), fade_index(v), fade_index(w));
                share = s;
            }
        }
    }
    // A vertex itself, if it is one.
    if (share.y == 1.0) index.x = index.y;
    if (share.z == 1.0) index.x = index.z;
    if (max(share.x, max(share.y, share.z)) == 1.0) share = vec3(1.0, 0.0, 0.0);
}
