// The height alone, in float throughout: as terrain/height.glsl has it with TERRAIN_FLOAT, without its gradient.
#include "terrain/height.glsl"

// Adds the fields from o on: c and b.
void terrain_far_fields(int o, vec3 far, inout vec2 fields) {
    if (o < TERRAIN_FIELDS) do {
        fields += terrain_table.fields[o].weights * terrain_noise_value(terrain_table.fields[o].lattice, far);
    } while (++o < TERRAIN_FIELDS);
}

#ifdef TERRAIN_ERODED
#define TERRAIN_FAR_GULLIES , inout Gullies gullies
#define TERRAIN_FAR_GULLIES_OF(t) , t

// A layer's value, v without gullies, at the place that its lattice is asked at. weight: what it has of the height.
float terrain_far_gully(int i, float v, vec3 at, float weight, inout Gullies gullies) {
    TerrainLayer layer = terrain_table.layers[i];
    // Others look at the first one's cells and keep what they have.
    bool own = i >= GULLY_FIRST && i < GULLY_END;
    if (own) {
        ivec3 cell;
        vec3 fraction;
        terrain_place(layer.lattice, at, cell, fraction);
        Gully gully = gully_layer(cell, fraction, layer.lattice.wavelength_m, layer.amplitude_m, mat3(1.0), gullies);
        v = mix(v, gully.wave, gully.share);
        gullies.furrows += weight * layer.amplitude_m * gully.share * gully.wave;
    }
    return v;
}
#else
#define TERRAIN_FAR_GULLIES
#define TERRAIN_FAR_GULLIES_OF(t)
#endif

// Adds layer i, whose noise is n, asked at a place: a and b of the ranges, metres of relief.
void terrain_far_layer(int i, float n, vec3 at, float spacing_m, inout vec2 shape, inout float z TERRAIN_FAR_GULLIES) {
    TerrainLayer layer = terrain_table.layers[i];
    n = terrain_ridge(n, layer.ridge);
    float shown = terrain_height_weight(layer.lattice.wavelength_m, spacing_m);
#ifdef TERRAIN_ERODED
    n = terrain_far_gully(i, n, at, shown, gullies);
#endif
    bool ranges = i < TERRAIN_SHAPE_LAYERS;
    shape += (ranges ? layer.range_weight * n : 0.0) * (i < TERRAIN_GATING_LAYERS ? vec2(1.0, 0.0) : vec2(0.0, 1.0));
#ifdef TERRAIN_MAPPED
    float weight = ranges ? 1.0 : shown;
#else
    float weight = ranges ? 0.0 : shown;
#endif
    z += weight * layer.amplitude_m * n;
}

// Adds the layers from i on that the spacing can show.
void terrain_far_layers(int i, vec3 D, vec3 near, float spacing_m, inout vec2 shape, inout float z
    TERRAIN_FAR_GULLIES) {
    int layers = terrain_table.layer_count, warped = terrain_table.warped_layers;
    int shapes = min(TERRAIN_SHAPE_LAYERS, layers);
    int end = min(max(terrain_layers_above(0.0625 * spacing_m), shapes), layers);
    if (i < end) do {
        vec3 at = i < warped ? near : D;
        terrain_far_layer(i, terrain_noise_value(terrain_table.layers[i].lattice, at), at, spacing_m, shape,
            z TERRAIN_FAR_GULLIES_OF(gullies));
    } while (++i < end);
}

// The height of these noises, with craters and the map. furrows: what of z is gullies.
float terrain_far_surface(vec3 D, float spacing_m, vec3 w1, vec2 fields, vec2 shape, float z, float furrows) {
    TerrainSources sources;
    float added = terrain_table.anchor.added_m + terrain_sources(D, spacing_m, sources);
    float h = terrain_surface(terrain_table.constants, w1.x, w1.y, w1.z, fields.x, fields.y, shape.x, shape.y, z,
        added, sources.rougher);
#ifdef TERRAIN_CARVED
    TerrainCut cut = terrain_cut(D);
    float base_m = terrain_table.rivers.base_m + cut.base, sides = terrain_side_rough(h, base_m, cut.open);
    h = terrain_carve(h, base_m, cut.open, cut.raised) + sides * furrows;
#endif
#ifdef TERRAIN_TILED
    RealGround real = terrain_real(D, spacing_m);
    float ground_m = terrain_table.real.ground_m + terrain_table.real.ground_rest_m;
    vec3 up = terrain_table.up + D / terrain_table.radius_m, unused;
    h = real.rest * h + real.height + (1.0 - real.rest) * ground_m
        + terrain_real_relief(real, D, up, spacing_m, unused);
#endif
    return h;
}

#ifdef TERRAIN_ERODED
// Which way is down there; w1 and fields in whole.
Gullies terrain_far_gullies(vec3 D, vec3 near, mat3 to_near, float spacing_m, vec3 w1, vec2 fields) {
    TerrainSources sources;
    float added = terrain_table.anchor.added_m + terrain_sources(D, spacing_m, sources);
#ifdef TERRAIN_CARVED
    TerrainCut cut = terrain_cut(D);
#endif
    return terrain_gullies(near, to_near, terrain_table.up + D / terrain_table.radius_m, w1, fields, added,
        sources.rougher,
#ifdef TERRAIN_CARVED
        cut,
#endif
        terrain_layers_above(0.0625 * spacing_m));
}
#endif

// D and spacing_m as terrain_point has them; metres above the reference sphere.
float terrain_far_height(vec3 D, float spacing_m) {
    mat3 unused;
    vec3 w1 = terrain_warp(terrain_table.wide_warp.lattice, D, unused);
    vec3 near = D + terrain_bend(terrain_table.narrow_warp, terrain_warp(terrain_table.narrow_warp.lattice, D, unused));
    vec3 far = near + terrain_bend(terrain_table.wide_warp, w1);

    vec2 fields = vec2(0.0), shape = vec2(0.0);
    terrain_far_fields(0, far, fields);
    float z = 0.0, furrows = 0.0;
#ifdef TERRAIN_ERODED
    Gullies gullies = terrain_far_gullies(D, near, mat3(1.0), spacing_m, w1, fields);
#endif
    terrain_far_layers(0, D, near, spacing_m, shape, z TERRAIN_FAR_GULLIES_OF(gullies));
#ifdef TERRAIN_ERODED
    furrows = gullies.furrows;
#endif
    return terrain_far_surface(D, spacing_m, w1, fields, shape, z, furrows);
}
