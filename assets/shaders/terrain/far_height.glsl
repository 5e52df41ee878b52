// The height alone, in float throughout: as terrain/height.glsl has it with TERRAIN_FLOAT, without its gradient.
#include "terrain/height.glsl"

float terrain_far_octave(TerrainOctave octave, vec3 d) {
    ivec3 cell;
    vec3 fraction;
    terrain_place(octave, d, cell, fraction);
    return gradient_noise_value(cell, fraction);
}

// Adds the fields from o on: c and b.
void terrain_far_fields(int o, vec3 far, inout vec2 fields) {
    if (o < TERRAIN_LAYER) do {
        fields += terrain_table.octaves[o].weights.xy * terrain_far_octave(terrain_table.octaves[o], far);
    } while (++o < TERRAIN_LAYER);
}

// Adds layer i, whose noise is n: a and b of the ranges, metres of relief.
void terrain_far_layer(int i, float n, float spacing_m, inout vec2 shape, inout float z) {
    vec4 weights = terrain_table.octaves[TERRAIN_LAYER + i].weights;
    float wavelength_m = terrain_table.octaves[TERRAIN_LAYER + i].fraction_lo.w;
    n = terrain_ridge(n, weights.z);
    bool ranges = i < TERRAIN_SHAPE_LAYERS;
    shape += (ranges ? weights.x * n : 0.0) * (i < TERRAIN_GATING_LAYERS ? vec2(1.0, 0.0) : vec2(0.0, 1.0));
#ifdef TERRAIN_MAPPED
    float weight = ranges ? 1.0 : terrain_height_weight(wavelength_m, spacing_m);
#else
    float weight = ranges ? 0.0 : terrain_height_weight(wavelength_m, spacing_m);
#endif
    z += weight * weights.y * n;
}

// Adds the layers from i on that the spacing can show.
void terrain_far_layers(int i, vec3 D, vec3 near, float spacing_m, inout vec2 shape, inout float z) {
    int layers = terrain_table.layers.x, warped = terrain_table.layers.y, shapes = min(TERRAIN_SHAPE_LAYERS, layers);
    int end = min(max(terrain_layers_above(0.0625 * spacing_m), shapes), layers);
    if (i < end) do {
        terrain_far_layer(i, terrain_far_octave(terrain_table.octaves[TERRAIN_LAYER + i], i < warped ? near : D),
            spacing_m, shape, z);
    } while (++i < end);
}

// The height of these noises, with craters and the map.
float terrain_far_surface(vec3 D, float spacing_m, vec3 w1, vec2 fields, vec2 shape, float z) {
    vec4 dug = vec4(0.0), rougher = vec4(0.0);
    double added = terrain_craters(D, spacing_m, dug);
#ifdef TERRAIN_MAPPED
    added += terrain_mapped(terrain_foot(D), spacing_m, dug, rougher);
#endif

    return terrain_surface(terrain_table.constants, w1.x, w1.y, w1.z, fields.x, fields.y, shape.x, shape.y, z,
        float(added), rougher.w);
}

// D and spacing_m as terrain_point has them; metres above the reference sphere.
float terrain_far_height(vec3 D, float spacing_m) {
    mat3 unused;
    vec3 w1 = terrain_warp(terrain_table.octaves[0], D, unused), w2 = terrain_warp(terrain_table.octaves[1], D, unused);
    vec3 near = D + terrain_table.warp_m.y * ((w2 - terrain_table.warp_hi[1].xyz) - terrain_table.warp_lo[1].xyz);
    vec3 far = near + terrain_table.warp_m.x * ((w1 - terrain_table.warp_hi[0].xyz) - terrain_table.warp_lo[0].xyz);

    vec2 fields = vec2(0.0), shape = vec2(0.0);
    terrain_far_fields(TERRAIN_FIELD, far, fields);
    float z = 0.0;
    terrain_far_layers(0, D, near, spacing_m, shape, z);
    return terrain_far_surface(D, spacing_m, w1, fields, shape, z);
}
