// Heights of places close to one another, in float as terrain/far_height.glsl: noises that are long against the
// distance between the places are evaluated once, with their gradients, and are straight lines from there. Of layers
// that is the noise, before ridges are made of it: those have crests.
//
// Define TERRAIN_AROUND_FAR: also where the places are so far apart that fields are short (loops that are never run
// cost time too).
#include "terrain/far_height.glsl"

struct TerrainAround {
    vec3 middle;
    TerrainBroad broad;  // w1 and fields in whole
    // fields up to the one, and layers up to the other, are long; other fields are taken out of `broad`
    int fields, layers;
#ifdef TERRAIN_ERODED
    Gullies gullies;
#endif
};

// Of the layers, xyz: gradient, w: value. Not in the struct, which is copied for each place.
vec4 terrain_around_noises[TERRAIN_WARPED_LAYERS];

// How many times as long as the extent: the warps, of which most of the bend is that of places far apart; fields, which
// are a small part of the slopes along coasts; layers. In the mean a coast is off by 0.01 to 0.02 pixels, and by 0.07
// along the limb.
const float TERRAIN_LONG_WARPS = 4.0, TERRAIN_LONG_FIELDS = 16.0, TERRAIN_LONG_LAYERS = 48.0;

// Whether places as far as this from the middle are close enough.
bool terrain_keeps_around(float extent_m) {
#ifdef TERRAIN_AROUND_FAR
    return TERRAIN_LONG_WARPS * extent_m < terrain_table.narrow_warp.lattice.wavelength_m;
#else
    return TERRAIN_LONG_FIELDS * extent_m < terrain_table.fields[TERRAIN_FIELDS - 1].lattice.wavelength_m;
#endif
}

// broad: of the middle. extent_m: how far places are from it at most.
TerrainAround terrain_around(TerrainBroad broad, vec3 middle, float extent_m) {
    TerrainAround t;
    t.middle = middle;
    t.broad = broad;
    t.fields = TERRAIN_FIELDS;
    t.layers = 0;
    t.broad.w1 += terrain_table.wide_warp.value;
    t.broad.fields += terrain_table.anchor.fields;
#ifdef TERRAIN_ERODED
    t.gullies = terrain_far_gullies(middle, broad.near, broad.to_near, extent_m, t.broad.w1, t.broad.fields);
#endif
#ifdef TERRAIN_AROUND_FAR
    while (t.fields > 0 && TERRAIN_LONG_FIELDS * extent_m
        > terrain_table.fields[t.fields - 1].lattice.wavelength_m) {
        TerrainFieldOctave field = terrain_table.fields[--t.fields];
        vec4 n = terrain_noise(field.lattice, broad.far);
        vec3 g = n.xyz * broad.to_far;
        t.broad.fields -= field.weights * n.w;
        t.broad.dc -= field.weights.x * g;
        t.broad.db -= field.weights.y * g;
    }
#endif
    t.layers = min(terrain_layers_above(TERRAIN_LONG_LAYERS * extent_m), terrain_table.warped_layers);
    int i = 0;
    if (i < t.layers) do {
        vec4 n = terrain_noise(terrain_table.layers[i].lattice, broad.near);
        terrain_around_noises[i] = vec4(n.xyz * broad.to_near, n.w);
    } while (++i < t.layers);
    return t;
}

// As terrain_far_height.
float terrain_height_around(TerrainAround t, vec3 D, float spacing_m) {
    vec3 d = D - t.middle, near = t.broad.near + t.broad.to_near * d;
    vec2 fields = t.broad.fields + vec2(dot(t.broad.dc, d), dot(t.broad.db, d));
#ifdef TERRAIN_AROUND_FAR
    terrain_far_fields(t.fields, t.broad.far + t.broad.to_far * d, fields);
#endif

    vec2 shape = vec2(0.0);
    float z = 0.0;
#ifdef TERRAIN_ERODED
    Gullies gullies = t.gullies;
    gullies.falls += gullies.d_falls * d;
#endif
    for (int i = 0; i < TERRAIN_WARPED_LAYERS; ++i) {
        if (i < t.layers) terrain_far_layer(i, terrain_around_noises[i].w + dot(terrain_around_noises[i].xyz, d), near,
            spacing_m, shape, z TERRAIN_FAR_GULLIES_OF(gullies));
    }
    terrain_far_layers(t.layers, D, near, spacing_m, shape, z TERRAIN_FAR_GULLIES_OF(gullies));
    float furrows = 0.0;
#ifdef TERRAIN_ERODED
    furrows = gullies.furrows;
#endif
    return terrain_far_surface(D, spacing_m, t.broad.w1 + t.broad.j1 * d, fields, shape, z, furrows);
}
