// Which way is down for gullies, by ranges, the longest relief and valleys of rivers: systems/terrain/height_eroded.py.
// Part of terrain/height.glsl.
#include "terrain/gullies.glsl"

const float TERRAIN_LEAST_CUT = 1e-6;   // of a height's share: less than that is none

// Noise at an octave's place as terrain_noise has it, and its second derivatives.
vec4 terrain_noise_hessian(TerrainLattice lattice, TERRAIN_PLACE d, out mat3 second) {
    ivec3 cell;
    vec3 f;
    terrain_place(lattice, d, cell, f);
    vec3 u = noise_weights(f), du = noise_weight_slopes(f), ddu = 60.0 * f * (f * (2.0 * f - 3.0) + 1.0);
    uvec3 side = uvec3(cell) * 1664525u + 1013904223u;
    vec4 sum = vec4(0.0);
    second = mat3(0.0);
    for (int k = 0; k < 8; ++k) {
        vec3 corner = vec3(k & 1, k >> 1 & 1, k >> 2), towards = 2.0 * corner - 1.0;
        vec3 w = 1.0 - corner + towards * u, dw = towards * du, ddw = towards * ddu;
        uvec3 at = side + uvec3(corner) * 1664525u;
        vec3 g = vec3(lattice_hash(at.x, at.y, at.z)) * NOISE_GRADIENT_SCALE;
        float value = dot(g, f - corner), weight = w.x * w.y * w.z;
        vec3 by = vec3(dw.x * w.y * w.z, w.x * dw.y * w.z, w.x * w.y * dw.z);
        sum += vec4(weight * g + value * by, weight * value);
        float xy = dw.x * dw.y * w.z, xz = dw.x * w.y * dw.z, yz = w.x * dw.y * dw.z;
        second += outerProduct(by, g) + outerProduct(g, by) + value * mat3(ddw.x * w.y * w.z, xy, xz, xy,
            w.x * ddw.y * w.z, yz, xz, yz, w.x * w.y * ddw.z);
    }
    sum.xyz *= lattice.frequency_per_m;
    second *= lattice.frequency_per_m * lattice.frequency_per_m;
    return sum;
}

// near: the place as the narrow warp moves it; to_near: how that changes with the place. w1, fields: in whole. added,
// rougher: by craters and map. shown: layers that are.
Gullies terrain_gullies(TERRAIN_PLACE near, mat3 to_near, vec3 up, vec3 w1, vec2 fields, float added, float rougher,
#ifdef TERRAIN_CARVED
    TerrainCut cut,
#endif
    int shown) {
    vec3 sums = vec3(0.0);   // a and b of the ranges, metres of relief
    mat3 d_sums = mat3(0.0), dd_a = mat3(0.0), dd_b = mat3(0.0), dd_z = mat3(0.0);
    // Nothing where no gully shows.
    int i = 0, end = shown > GULLY_FIRST ? GULLY_FIRST : 0;
    if (i < end) do {
        TerrainLayer layer = terrain_table.layers[i];
        mat3 second;
        vec4 n = terrain_noise_hessian(layer.lattice, near, second);
        float inside = clamp(n.w * (1.0 / GULLY_CREST), -1.0, 1.0);
        float crest = 1.0 - abs(layer.ridge) - layer.ridge * GULLY_RIDGE_SLOPE * inside;
        float bend = abs(inside) < 1.0 ? layer.ridge * (-GULLY_RIDGE_SLOPE / GULLY_CREST) : 0.0;
        second = bend * outerProduct(n.xyz, n.xyz) + crest * second;
        bool gating = i < TERRAIN_GATING_LAYERS;
        vec3 weights = vec3(gating ? layer.range_weight : 0.0, gating ? 0.0 : layer.range_weight, layer.amplitude_m);
        sums += weights * terrain_ridge(n.w, layer.ridge);
        d_sums += outerProduct(crest * n.xyz, weights);
        dd_a += weights.x * second;
        dd_b += weights.y * second;
        dd_z += weights.z * second;
    } while (++i < end);
    TerrainSurfaceSlopes t = terrain_surface_slopes(terrain_table.constants, w1.x, w1.y, w1.z, fields.x, fields.y,
        sums.x, sums.y, sums.z, added, rougher, sums.z);
    vec3 by = vec3(t.by_sa, t.by_sb, t.by_z), aside = vec3(0.0);
    float sides = 0.0;
    mat3 d_aside = mat3(0.0);
#ifdef TERRAIN_CARVED
    float base_m = terrain_table.rivers.base_m + cut.base;
    TerrainCarveSlopes carved = terrain_carve_slopes(t.value, base_m, cut.open, cut.raised);
    // A valley's side is a parabola: open'' = -open'^2 / (2 (1 - open)).
    vec3 uncarved = d_sums * by, bow = (0.5 * carved.by_open / max(1.0 - cut.open, TERRAIN_LEAST_CUT)) * cut.d_open;
    vec3 over = (carved.by_open > 0.0 ? uncarved - cut.d_base : vec3(0.0)) - bow;
    d_aside = outerProduct(uncarved, cut.d_open) + outerProduct(cut.d_open, over);
    by *= carved.by_h;
    aside = carved.by_open * cut.d_open;
    sides = terrain_side_rough(t.value, base_m, cut.open);
#endif
    return Gullies(d_sums * by + aside, (by.x * dd_a + by.y * dd_b + by.z * dd_z) * to_near + d_aside, up,
        by.z + sides, terrain_table.erosion, 0.0, 0.0, vec3(0.0));
}
