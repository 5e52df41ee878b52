// The height alone, in float throughout: as terrain/height.glsl has it with TERRAIN_FLOAT, without its gradient.
#include "terrain/height.glsl"

float terrain_far_octave(TerrainOctave octave, vec3 d) {
    ivec3 cell;
    vec3 fraction;
    terrain_place(octave, d, cell, fraction);
    return gradient_noise_value(cell, fraction);
}

// D and spacing_m as terrain_point has them; metres above the reference sphere.
float terrain_far_height(vec3 D, float spacing_m) {
    TerrainConstants k = terrain_table.constants;
    mat3 unused;
    vec3 w1 = terrain_warp(terrain_table.octaves[0], D, unused), w2 = terrain_warp(terrain_table.octaves[1], D, unused);
    vec3 near = D + terrain_table.warp_m.y * ((w2 - terrain_table.warp_hi[1].xyz) - terrain_table.warp_lo[1].xyz);
    vec3 far = near + terrain_table.warp_m.x * ((w1 - terrain_table.warp_hi[0].xyz) - terrain_table.warp_lo[0].xyz);

    vec2 fields = vec2(0.0);
    int o = TERRAIN_FIELD;
    do {
        fields += terrain_table.octaves[o].weights.xy * terrain_far_octave(terrain_table.octaves[o], far);
    } while (++o < TERRAIN_LAYER);

    int layers = terrain_table.layers.x, warped = terrain_table.layers.y, shapes = min(TERRAIN_SHAPE_LAYERS, layers);
    int end = min(max(terrain_layers_above(0.0625 * spacing_m), shapes), layers);
    vec2 shape = vec2(0.0);
    float z = 0.0;
    int i = 0;
    do {
        TerrainOctave octave = terrain_table.octaves[TERRAIN_LAYER + i];
        float n = terrain_ridge(terrain_far_octave(octave, i < warped ? near : D), octave.weights.z);
        bool ranges = i < TERRAIN_SHAPE_LAYERS;
        shape += (ranges ? octave.weights.x * n : 0.0) * (i < TERRAIN_GATING_LAYERS ? vec2(1.0, 0.0) : vec2(0.0, 1.0));
#ifdef TERRAIN_MAPPED
        float weight = ranges ? 1.0 : terrain_height_weight(octave.fraction_lo.w, spacing_m);
#else
        float weight = ranges ? 0.0 : terrain_height_weight(octave.fraction_lo.w, spacing_m);
#endif
        z += weight * octave.weights.y * n;
    } while (++i < end);

    vec4 dug = vec4(0.0), rougher = vec4(0.0);
    double added = terrain_craters(D, spacing_m, dug);
#ifdef TERRAIN_MAPPED
    added += terrain_mapped(terrain_foot(D), spacing_m, dug, rougher);
#endif

    return terrain_surface(k, w1, fields.x, fields.y, shape, z, float(added), rougher.w);
}
