// What the height function adds to its noise: craters and a height map, each compiled only where
// contract/height_sources.glsl asks for it. Part of terrain/height.glsl, which has the table and terrain_place.

#include "generated/bindings.glsl"

#ifdef TERRAIN_TILED
layout(binding = HEIGHT_MAP_UNIT) uniform usampler2D u_real_ground;
#elif defined(TERRAIN_MAPPED)
layout(binding = HEIGHT_MAP_UNIT) uniform sampler2D u_terrain_map;  // metres; height differences of the finest scale
#endif

// Beside metres, what craters and map add.
struct TerrainSources {
    vec3 gradient;   // of the metres, not yet tangential
    float dug;       // how freshly craters have dug the ground, 0..1
    vec3 d_rougher;  // the gradient of
    float rougher;   // the relief's roughness by the map
};

const TerrainSources NO_SOURCES = TerrainSources(vec3(0.0), 0.0, vec3(0.0), 0.0);

#ifdef TERRAIN_CRATERED
#include "terrain/craters.glsl"

// An octave of craters at offset d; the rest as terrain_crater_octave has it.
float terrain_crater(CraterOctave octave, TERRAIN_PLACE d, vec3 up, float spacing_m, float begin_m,
    inout TerrainSources ground) {
    ivec3 cell;
    CRATER_FRACTION fraction;
    terrain_place(octave.lattice, d, cell, fraction);
    return terrain_crater_octave(octave, cell, fraction, up, spacing_m, begin_m, ground);
}

#ifndef TERRAIN_CANONICAL
#include "terrain/crater_change.glsl"
#endif

// How many octaves of craters have any wider than a length.
int terrain_craters_above(float length_m) {
    int octaves = terrain_table.crater_octaves;
    float widest_m = 0.5 * terrain_table_craters(0).lattice.wavelength_m;
    return octaves > 0 ? int(clamp(ceil(log2(widest_m / length_m)), 0.0, float(octaves))) : 0;
}

// Metres that craters add at offset D; of wide ones as a change from the anchor.
#ifdef TERRAIN_CANONICAL
Pair terrain_craters(Fixed3 D, float spacing_m, inout TerrainSources ground) {
    int end = terrain_table.crater_octaves, coarse = terrain_table.coarse_crater_octaves, i = 0;
    Pair sum = pair(0.0), units = pair_div(1.0, pair(terrain_table.radius_m / terrain_table.fixed_unit_m));
    Pair3 up = pair_mul(fixed_pair(D), units);
    if (i < coarse) do {
        ivec3 cell;
        uvec3 fraction;
        CraterOctave octave = terrain_table_craters(i);
        terrain_place(octave.lattice, D, cell, fraction);
        sum = pair_add(sum, terrain_crater_octave(octave, cell, fraction, up, spacing_m, 0.0, ground));
    } while (++i < coarse);
    float fine = 0.0;
    if (i < end) do {
        fine += terrain_crater(terrain_table_craters(i), D, up.high, spacing_m, 0.0, ground);
    } while (++i < end);
    return pair_add(sum, fine);
}
#else
float terrain_craters(vec3 D, float spacing_m, inout TerrainSources ground) {
    int end = terrain_craters_above(0.0625 * spacing_m), coarse = min(terrain_table.coarse_crater_octaves, end), i = 0;
    float sum = 0.0;
    vec3 up = terrain_table.up + D / terrain_table.radius_m;
    if (i < coarse) do {
#ifdef TERRAIN_FLOAT
        CraterOctave octave = terrain_table_craters(i);
        sum += terrain_crater(octave, D, up, spacing_m, 0.0, ground) - octave.lattice.value;
#else
        sum += terrain_crater_change(terrain_table_craters(i), D, up, spacing_m, ground);
#endif
    } while (++i < coarse);
    if (i < end) do {
        sum += terrain_crater(terrain_table_craters(i), D, up, spacing_m, 0.0, ground);
    } while (++i < end);
    for (; i < terrain_table.coarse_crater_octaves; ++i) sum -= terrain_table_craters(i).lattice.value;
    return sum;
}

// What terrain_point left out of the craters between the vertices' spacing and the pixel's footprint: the
// gradient is tangential. Craters of an octave differ in width by a factor of four.
TerrainSources terrain_crater_detail(vec3 D, float spacing_vertex_m, float footprint_m) {
    int begin = max(terrain_craters_above(16.0 * spacing_vertex_m), 0), end = terrain_craters_above(2.0 * footprint_m);
    vec3 up = terrain_table.up + D / terrain_table.radius_m;
    TerrainSources ground = NO_SOURCES;
    int i = begin;
    if (i < end) do {
        terrain_crater(terrain_table_craters(i), D, up, footprint_m, spacing_vertex_m, ground);
    } while (++i < end);
    ground.gradient -= up * dot(up, ground.gradient);
    return ground;
}
#endif
#else
TerrainSources terrain_crater_detail(vec3 D, float spacing_vertex_m, float footprint_m) {
    return NO_SOURCES;
}
#endif

#ifdef TERRAIN_MAPPED
#include "terrain/height_map.glsl"

// Metres of the height map, as a change from the anchor; 0 without one.
TERRAIN_REAL terrain_mapped(TERRAIN_PLACE D, float spacing_m, inout TerrainSources ground) {
    TERRAIN_REAL h = TERRAIN_NUMBER(0.0);
    if (terrain_table.map.cells > 0) {
        vec3 slope, d_rough;
        float rough;
        h = terrain_map_height(D, spacing_m, slope, rough, d_rough);
        ground.gradient += slope;
        rough *= terrain_table.map.roughness_per_m;
        bool below = rough < TERRAIN_MOST_ROUGH;
        ground.rougher = below ? rough : TERRAIN_MOST_ROUGH;
        ground.d_rougher = below ? terrain_table.map.roughness_per_m * d_rough : vec3(0.0);
    }
    return h;
}

// What terrain_point left out of the height map: its gradient between the vertices' spacing and the footprint,
// tangential.
vec3 terrain_mapped_detail(vec3 D, float spacing_vertex_m, float footprint_m) {
    vec3 sum = vec3(0.0);
    if (terrain_table.map.cells > 0) {
        vec3 up = terrain_table.up + D / terrain_table.radius_m;
        sum = terrain_map_detail(up * terrain_table.radius_m, spacing_vertex_m, footprint_m);
        sum -= up * dot(up, sum);
    }
    return sum;
}
#else
vec3 terrain_mapped_detail(vec3 D, float spacing_vertex_m, float footprint_m) {
    return vec3(0.0);
}
#endif

#ifdef TERRAIN_TILED
#include "terrain/real_ground.glsl"
#endif

// Metres that both add, as a change from the anchor.
TERRAIN_REAL terrain_sources(TERRAIN_PLACE D, float spacing_m, out TerrainSources ground) {
    ground = NO_SOURCES;
    TERRAIN_REAL added = TERRAIN_NUMBER(0.0);
#ifdef TERRAIN_CRATERED
    added = TERRAIN_SUM(added, terrain_craters(D, spacing_m, ground));
#endif
#ifdef TERRAIN_MAPPED
    added = TERRAIN_SUM(added, terrain_mapped(D, spacing_m, ground));
#endif
    return added;
}
