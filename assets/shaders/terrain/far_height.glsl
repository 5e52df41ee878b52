// The height alone, in float throughout: for pixels that are tens of metres wide. Within 0.1 m of terrain_point's on Earth, of which
// a place thousands of kilometres from the anchor takes the most; half of the time.
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

    // terrain_surface in float.
    float s = shape.x + mix(TERRAIN_GATE_SHUT, 1.0, terrain_step((shape.x + TERRAIN_GATE_LOW) / TERRAIN_GATE_WIDTH)) * shape.y;
    float x = (fields.x - k.sea_level) * k.inverse_deviation + k.coast * s;
    float along = terrain_bump(fields.y * k.inverse_belt) * terrain_step((w1.x + 0.35) * 2.0);
    float coastal = terrain_bump((x - 0.3) / 0.3) * terrain_step((w1.y - 0.05) / 0.3) * k.mountains;
    float belts = 1.0 - (1.0 - along) * (1.0 - coastal);
    float on_land = belts * (0.3 + 0.7 * terrain_step((x + 0.5) / 0.6));
    float m = terrain_step((s + k.shape_low) * k.shape_inverse);
    float calm = k.flat_ + k.hills * terrain_step((w1.z + 0.1) * 2.0) * (1.0 - belts);
    float rough = calm * (0.5 + m) + on_land * (k.calm + k.wild * m) + rougher.w;
    float h = terrain_hypsometry(k, x) + on_land * (k.foot_m + k.range_m * m) + calm * k.hill_m * m + rough * z + float(added);
    float over = max(h - k.knee_high_m, 0.0), under = max(k.knee_low_m - h, 0.0);
    return h - over * over / (over + k.room_high_m) + under * under / (under + k.room_low_m);
}
