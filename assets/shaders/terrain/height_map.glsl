// The height map: systems/terrain/height_map.py. Bicubic from texelFetch: each sample as a difference from one of them,
// places and totals as differences from the anchor's.
#include "generated/bindings.glsl"
#include "generated/terrain_table.glsl"
#include "common/cube_atlas.glsl"


// Catmull-Rom weights and their derivatives.
vec4 terrain_map_weights(float f) {
    return vec4(f * (-0.5 + f * (1.0 - 0.5 * f)), 1.0 + f * f * (1.5 * f - 2.5), f * (0.5 + f * (2.0 - 1.5 * f)),
        f * f * (0.5 * f - 0.5));
}

vec4 terrain_map_weight_slopes(float f) {
    return vec4(-0.5 + f * (2.0 - 1.5 * f), f * (4.5 * f - 5.0), 0.5 + f * (4.0 - 4.5 * f), f * (1.5 * f - 1.0));
}

// Both channels at `fraction` beyond a sample, as differences from it, which is `center`; and their derivatives by it.
vec2 terrain_map_cubic(ivec2 corner, vec2 fraction, out vec2 center, out vec2 by_x, out vec2 by_y) {
    vec4 wx = terrain_map_weights(fraction.x), wy = terrain_map_weights(fraction.y);
    vec4 dwx = terrain_map_weight_slopes(fraction.x), dwy = terrain_map_weight_slopes(fraction.y);
    vec2 sum = vec2(0.0);
    center = texelFetch(u_terrain_map, corner + 1, 0).rg;
    by_x = by_y = vec2(0.0);
    for (int b = 0; b < 4; ++b) {
        vec2 t0 = texelFetch(u_terrain_map, corner + ivec2(0, b), 0).rg - center,
            t1 = texelFetch(u_terrain_map, corner + ivec2(1, b), 0).rg - center;
        vec2 t2 = texelFetch(u_terrain_map, corner + ivec2(2, b), 0).rg - center,
            t3 = texelFetch(u_terrain_map, corner + ivec2(3, b), 0).rg - center;
        vec2 row = wx.x * t0 + wx.y * t1 + wx.z * t2 + wx.w * t3;
        sum += wy[b] * row;
        by_x += wy[b] * (dwx.x * t0 + dwx.y * t1 + dwx.z * t2 + dwx.w * t3);
        by_y += dwy[b] * row;
    }
    return sum;
}

// The gradient of heights at one level, by the direction d. cells: a face's side at the finest level.
vec3 terrain_map_slope(vec3 d, int cells, int level) {
    int face, n = cells >> level;
    vec3 place = cube_face(d, face);
    vec2 at = (place.xy * 0.5 + 0.5) * float(n), cell = clamp(floor(at), 0.0, float(n - 1));
    vec2 center, by_x, by_y;
    terrain_map_cubic(cube_corner(face, cells, level) + ivec2(cell), at - cell, center, by_x, by_y);
    return cube_gradient(face, place, 0.5 * float(n) * vec2(by_x.x, by_y.x));
}

// The level, a fraction, whose gradients samples spacing_m apart show.
float terrain_map_level(float spacing_m) {
    float levels = log2(TERRAIN_LEVEL_SAMPLES * spacing_m / terrain_table.map.sample_m);
    return clamp(levels, 0.0, float(terrain_table.map.levels - 1));
}

#ifdef TERRAIN_CANONICAL
// Where the place D is: its face, the foot's direction there, and in the map.
vec3 terrain_map_place(Fixed3 D, int n, out int face, out ivec2 cell, out vec2 fraction) {
    Pair3 foot = fixed_pair(D);
    vec3 place = cube_face(foot.high * terrain_table.fixed_unit_m, face);
    Pair3 along = Pair3(cube_axes(face, foot.high), cube_axes(face, foot.low));
    float half_side = 0.5 * float(n);
    Pair x = pair_mul(pair_div(PAIR_PART(along, x), PAIR_PART(along, z)), half_side);
    Pair y = pair_mul(pair_div(PAIR_PART(along, y), PAIR_PART(along, z)), half_side);
    vec2 whole = floor(vec2(x.high, y.high)) + half_side;
    cell = clamp(ivec2(floor(whole)), 0, n - 1);
    fraction = (vec2(x.high, y.high) - (vec2(cell) - half_side)) + vec2(x.low, y.low);
    return place;
}
#else
vec3 terrain_map_place(vec3 D, int n, out int face, out ivec2 cell, out vec2 fraction) {
    vec3 place = cube_face(terrain_table.up * terrain_table.radius_m + D, face), d = cube_axes(face, D);
    TerrainMapFace seen = terrain_table.map_faces[face];
    vec2 at = (place.xy * 0.5 + 0.5) * float(n);
    if (seen.near != 0) {  // p / p.z less the anchor's a / a.z is (d - a / a.z d.z) / p.z, where p = a + d
        vec2 moved = (d.xy - seen.place * d.z) * (0.5 * float(n) / place.z), whole = floor(moved);
        at = (moved - whole) + seen.fraction;
        cell = seen.cell + ivec2(whole);
    } else {
        cell = ivec2(0);
    }
    ivec2 inside = clamp(cell + ivec2(floor(at)), 0, n - 1);
    fraction = at - vec2(inside - cell);
    cell = inside;
    return place;
}
#endif

// Height in metres over the anchor's at offset D, its gradient as spacing_m shows it, and the same of the height
// differences at the map's finest scale, in whole.
TERRAIN_REAL terrain_map_height(TERRAIN_PLACE D, float spacing_m, out vec3 gradient, out float rough,
    out vec3 d_rough) {
    int face, n = terrain_table.map.cells;
    ivec2 cell;
    vec2 fraction, center, by_x, by_y;
    vec3 near = terrain_map_place(D, n, face, cell, fraction);
    vec2 sum = terrain_map_cubic(cube_corner(face, n, 0) + cell, fraction, center, by_x, by_y);
    float level = terrain_map_level(spacing_m);
    gradient = max(1.0 - level, 0.0) * cube_gradient(face, near, 0.5 * float(n) * vec2(by_x.x, by_y.x));
    vec3 foot = terrain_table.up * terrain_table.radius_m + terrain_offset(D);
    int l = max(int(level), 1), last = int(ceil(level));
    if (l <= last) do {
        gradient += max(1.0 - abs(level - float(l)), 0.0) * terrain_map_slope(foot, n, l);
    } while (++l <= last);
    rough = max(center.y + sum.y, 0.0);
    d_rough = rough > 0.0 ? cube_gradient(face, near, 0.5 * float(n) * vec2(by_x.y, by_y.y)) : vec3(0.0);
    return TERRAIN_SUM(center.x - terrain_table.anchor.map_m, sum.x);
}

// What the gradient at spacing_m leaves out and footprint_m shows.
vec3 terrain_map_detail(vec3 d, float spacing_m, float footprint_m) {
    float coarse = terrain_map_level(spacing_m), fine = terrain_map_level(footprint_m);
    int l = int(fine), last = coarse > fine ? int(ceil(coarse)) : -1;
    vec3 sum = vec3(0.0);
    if (l <= last) do {
        float weight = max(1.0 - abs(fine - float(l)), 0.0) - max(1.0 - abs(coarse - float(l)), 0.0);
        sum += weight * terrain_map_slope(d, terrain_table.map.cells, l);
    } while (++l <= last);
    return sum;
}
