// What the height function adds to its noise: craters and a height map, each compiled only where
// contract/height_sources.glsl asks for it. Part of terrain/height.glsl, which has the table and terrain_place.
#include "common/cube_atlas.glsl"

#ifdef TERRAIN_CRATERED
#include "terrain/craters.glsl"

// An octave of craters at offset d. up: the place over the radius. Evaluators with places of their own: the wide ones
// (the first terrain_table.layers.w) are for double, the others want their fraction from double or from an anchor
// nearby.
double terrain_crater_double(TerrainOctave octave, dvec3 d, dvec3 up, float spacing_m, inout vec4 ground) {
    ivec3 cell;
    dvec3 fraction;
    terrain_place(octave, d, cell, fraction);
    double curve = double(octave.fraction_lo.w) / double(terrain_table.up.w);
    return terrain_crater_octave(cell, fraction, up, curve, octave.weights, octave.fraction_lo.w,
        int(terrain_table.up_low.w), spacing_m, 0.0, spacing_m, ground);
}

float terrain_crater(TerrainOctave octave, vec3 d, vec3 up, float spacing_m, inout vec4 ground) {
    ivec3 cell;
    vec3 fraction;
    terrain_place(octave, d, cell, fraction);
    return terrain_crater_octave(cell, fraction, up, octave.fraction_lo.w / terrain_table.up.w, octave.weights,
        octave.fraction_lo.w, int(terrain_table.up_low.w), spacing_m, 0.0, spacing_m, ground);
}

float terrain_crater(TerrainOctave octave, dvec3 d, vec3 up, float spacing_m, inout vec4 ground) {
    ivec3 cell;
    dvec3 fraction;
    terrain_place(octave, d, cell, fraction);
    return terrain_crater_octave(cell, vec3(fraction), up, octave.fraction_lo.w / terrain_table.up.w, octave.weights,
        octave.fraction_lo.w, int(terrain_table.up_low.w), spacing_m, 0.0, spacing_m, ground);
}

// How many octaves of craters have any wider than a length.
int terrain_craters_above(float length_m) {
    float widest_m = 0.5 * terrain_table.craters[0].fraction_lo.w;
    return terrain_table.layers.z > 0 ? int(clamp(ceil(log2(widest_m / length_m)), 0.0, float(terrain_table.layers.z)))
        : 0;
}

// Metres that craters add at offset D. ground: adds their gradient (not yet tangential), and to w how freshly dug it
// is.
double terrain_craters(TERRAIN_PLACE D, float spacing_m, inout vec4 ground) {
#ifdef TERRAIN_CANONICAL
    int end = terrain_table.layers.z;
#else
    int end = terrain_craters_above(0.0625 * spacing_m);
#endif
    int coarse = min(terrain_table.layers.w, end);
    double sum = 0.0LF;
    dvec3 up = dvec3(terrain_table.up.xyz) + dvec3(terrain_table.up_low.xyz) + dvec3(D) / double(terrain_table.up.w);
    int i = 0;
    if (i < coarse) do {
        sum += terrain_crater_double(terrain_table.craters[i], dvec3(D), up, spacing_m, ground);
    } while (++i < coarse);
    float fine = 0.0;
    if (i < end) do {
        fine += terrain_crater(terrain_table.craters[i], D, vec3(up), spacing_m, ground);
    } while (++i < end);
    return sum + double(fine);
}

// What terrain_point left out of the craters between the vertices' spacing and the pixel's footprint: gradient
// (tangential), and in w how freshly dug the ground is. Craters of an octave differ in width by a factor of four.
vec4 terrain_crater_detail(vec3 D, float spacing_vertex_m, float footprint_m) {
    int begin = max(terrain_craters_above(16.0 * spacing_vertex_m), 0), end = terrain_craters_above(2.0 * footprint_m);
    vec3 up = terrain_table.up.xyz + D / terrain_table.up.w;
    vec4 ground = vec4(0.0);
    int i = begin;
    if (i < end) do {
        TerrainOctave octave = terrain_table.craters[i];
        ivec3 cell;
        vec3 fraction;
        terrain_place(octave, D, cell, fraction);
        terrain_crater_octave(cell, fraction, up, octave.fraction_lo.w / terrain_table.up.w, octave.weights,
            octave.fraction_lo.w, int(terrain_table.up_low.w), footprint_m, spacing_vertex_m, footprint_m, ground);
    } while (++i < end);
    ground.xyz -= up * dot(up, ground.xyz);
    return ground;
}
#else
double terrain_craters(TERRAIN_PLACE D, float spacing_m, inout vec4 ground) {
    return 0.0LF;
}

vec4 terrain_crater_detail(vec3 D, float spacing_vertex_m, float footprint_m) {
    return vec4(0.0);
}
#endif

#ifdef TERRAIN_MAPPED
#include "terrain/height_map.glsl"

// The foot at offset D, from the planet's centre.
dvec3 terrain_foot(TERRAIN_PLACE D) {
    return (dvec3(terrain_table.up.xyz) + dvec3(terrain_table.up_low.xyz)) * double(terrain_table.up.w) + dvec3(D);
}

const float TERRAIN_MOST_ROUGH = 1.2;

// Metres of the height map at `foot` (planet-centred metres), 0 without one. ground: adds its gradient; rougher: the
// relief's roughness by the map and its gradient in xyz, roughness in w.
double terrain_mapped(dvec3 foot, float spacing_m, inout vec4 ground, out vec4 rougher) {
    double h = 0.0LF;
    rougher = vec4(0.0);
    if (terrain_table.map.x > 0) {
        vec3 slope, d_rough;
        float rough;
        h = terrain_map_height(foot, terrain_table.map.xy, terrain_table.map_scale.x, spacing_m, slope, rough, d_rough);
        ground.xyz += slope;
        rough *= terrain_table.map_scale.y;
        rougher = rough < TERRAIN_MOST_ROUGH ? vec4(terrain_table.map_scale.y * d_rough, rough)
            : vec4(vec3(0.0), TERRAIN_MOST_ROUGH);
    }
    return h;
}

// What terrain_point left out of the height map: its gradient between the vertices' spacing and the footprint,
// tangential.
vec3 terrain_mapped_detail(vec3 D, float spacing_vertex_m, float footprint_m) {
    vec3 sum = vec3(0.0);
    if (terrain_table.map.x > 0) {
        vec3 up = terrain_table.up.xyz + D / terrain_table.up.w;
        sum = terrain_map_detail(up * terrain_table.up.w, terrain_table.map.xy, terrain_table.map_scale.x,
            spacing_vertex_m, footprint_m);
        sum -= up * dot(up, sum);
    }
    return sum;
}
#else
vec3 terrain_mapped_detail(vec3 D, float spacing_vertex_m, float footprint_m) {
    return vec3(0.0);
}
#endif
