// The height of the ground, its gradient and roughness, around an anchor: the GPU's side of systems/terrain/height*.py
// (height_surface.py has the statements of its point-wise part). Point-wise function of a few noises, see
// docs/terrain-height.md:
//   w1 w2 warps;  c continents, b belts (warped by both);  s ranges, z relief (the layers; the ridged ones warped by
//   w2)
// Coordinates: D = foot on the reference sphere minus the anchor's, metres, planet axes, f32. An octave's lattice place
// is the anchor's (cell and fraction from float64) plus D * frequency, exact products: frequencies are powers of two.
// Warps, continents, belts, ranges and the point-wise part are evaluated in double (4.2 ns against 2.9 an octave on
// llvmpipe), the relief and all gradients in float: a millimetre is 1e-7 of a 9 km relief, and belts magnify rounding.
// Worst errors on Earth: 0.6 mm anywhere in view, 0.14 mm within 1 km of the anchor.
#include "generated/bindings.glsl"
#include "contract/height_sources.glsl"
#include "common/noise.glsl"

const float TERRAIN_RIDGE_TOP = 0.30, TERRAIN_RIDGE_SLOPE = 1.9, TERRAIN_RIDGE_ROUND = 0.03;

float terrain_smoothstep_slope(float t) {
    t = clamp(t, 0.0, 1.0);
    return 6.0 * t * (1.0 - t);
}

float terrain_bump_slope(float t) {
    return -4.0 * t * max(1.0 - t * t, 0.0);
}

float terrain_positive_slope(float t) {
    return t > 0.0 ? 1.0 : 0.0;
}

float terrain_ridge_slope(float n, float ridge) {
    return 1.0 - abs(ridge) - ridge * TERRAIN_RIDGE_SLOPE * clamp(n / TERRAIN_RIDGE_ROUND, -1.0, 1.0);
}

// What statements of height_surface.py call, in both precisions; and a layer's value from its noise: a mix of the noise
// and its ridges (top - slope |n|, the crest rounded).
#define TERRAIN_STEPS(REAL) \
    REAL terrain_smoothstep(REAL t) { \
        t = clamp(t, REAL(0.0), REAL(1.0)); \
        return t * t * (REAL(3.0) - REAL(2.0) * t); \
    } \
    REAL terrain_bump(REAL t) { \
        t = max(REAL(1.0) - t * t, REAL(0.0)); \
        return t * t; \
    } \
    REAL terrain_positive(REAL t) { \
        return max(t, REAL(0.0)); \
    } \
    REAL terrain_ridge(REAL n, REAL ridge) { \
        REAL a = abs(n), low = min(a, REAL(TERRAIN_RIDGE_ROUND)); \
        a += low * low * (REAL(0.5) / REAL(TERRAIN_RIDGE_ROUND)) - low; \
        return (REAL(1.0) - abs(ridge)) * n + ridge * (REAL(TERRAIN_RIDGE_TOP) - REAL(TERRAIN_RIDGE_SLOPE) * a); \
    }

TERRAIN_STEPS(float)
TERRAIN_STEPS(double)

#include "generated/terrain_surface.glsl"

struct TerrainPoint {
    float dh;         // height above the anchor's height, metres
    vec3 gradient;    // surface gradient of the height at the foot: tangent vector in planet axes, metres per metre
    float roughness;  // multiplier of the layers, 0..1.2: interpolate it, hand it to terrain_detail_gradient
    float moisture;   // 0 dry .. 1 wet, for materials
    float mountains;  // 0..1 where ranges stand, for materials
};

struct TerrainOctave {
    ivec4 cell;          // of the anchor
    vec4 fraction_hi;    // w: frequency, 1/m
    vec4 fraction_lo;    // w: wavelength, m
    vec4 weights;        // c and b: x, y. Layers: x in s, y in z (metres), z share of the ridge transform
};

const int TERRAIN_FIELD = 2, TERRAIN_LAYER = 9, TERRAIN_SHAPE_LAYERS = 4, TERRAIN_OCTAVES = 25, TERRAIN_CRATERS = 18;

// A uniform block, or with TERRAIN_TABLE_STORAGE a storage buffer of the same layout: llvmpipe reads an array in a
// storage buffer lane by lane, 5 ns an octave more.
#ifndef TERRAIN_TABLE_STORAGE
layout(std140, binding = TERRAIN_TABLE_BLOCK) uniform TerrainTable {
#else
layout(std430, binding = TERRAIN_TABLE_BUFFER) readonly buffer TerrainTable {
#endif
    vec4 warp_hi[2];
    vec4 warp_lo[2];
    vec4 up;  // of the anchor; w: radius, m
    vec2 height_m;
    vec2 warp_m;
    ivec4 layers;  // count, how many of them are warped; octaves of craters, how many of them are evaluated in double
    vec4 up_low;   // what up lacks in float; w: of 256 cells, those with a crater
    ivec4 map;     // cells a side of a face of the height map, 0: none; levels; the same of the colour map
    vec4 map_scale;  // distance of its samples in m; roughness by its height differences, 1/m; strength of colours
    TerrainConstants constants;
    TerrainOctave octaves[TERRAIN_OCTAVES];
    TerrainOctave craters[TERRAIN_CRATERS];  // weights: wall, floor, rim and peak by radius
} terrain_table;

const float TERRAIN_DUG_DRY = 0.3;  // what fresh craters take off the moisture: they show what lies below dark plains
const float TERRAIN_COLORED_MOISTURE = 0.45;  // where a colour map says what the ground looks like

// TERRAIN_CANONICAL: the table is around the planet's centre and places are double, so that heights are functions of
// nothing but the place, with all layers whatever the spacing. terrain/canonical_height.glsl.
#ifdef TERRAIN_CANONICAL
#define TERRAIN_PLACE dvec3
#else
#define TERRAIN_PLACE vec3
#endif

// TERRAIN_FLOAT: float throughout, for pixels that are tens of metres wide. Within 0.1 m on Earth, of which a place
// thousands of kilometres from the anchor takes the most; half of the time.
#ifdef TERRAIN_FLOAT
#define TERRAIN_REAL float
#define TERRAIN_REAL2 vec2
#define TERRAIN_REAL3 vec3
#else
#define TERRAIN_REAL double
#define TERRAIN_REAL2 dvec2
#define TERRAIN_REAL3 dvec3
#endif

const int TERRAIN_GATING_LAYERS = 2;

// Share of a layer in band-limited gradients: 0 below two samples a wavelength, 1 from four on.
float terrain_layer_weight(float wavelength_m, float spacing_m) {
    float t = clamp(wavelength_m / spacing_m * 0.5 - 1.0, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

// Share of a layer in heights: only layers shorter than an eighth of the spacing fade, which no vertex can show.
float terrain_height_weight(float wavelength_m, float spacing_m) {
#ifdef TERRAIN_CANONICAL
    return 1.0;
#endif
    float t = clamp(wavelength_m / spacing_m * 16.0 - 1.0, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

// How many layers are longer than a length.
int terrain_layers_above(float length_m) {
    float first_m = terrain_table.octaves[TERRAIN_LAYER].fraction_lo.w;
    return int(clamp(ceil(log2(first_m / length_m)), 0.0, float(terrain_table.layers.x)));
}

void terrain_place(TerrainOctave octave, vec3 d, out ivec3 cell, out vec3 fraction) {
    vec3 t = d * octave.fraction_hi.w;
    vec3 whole = floor(t);
    fraction = (t - whole) + octave.fraction_hi.xyz;
    vec3 carry = floor(fraction);
    fraction -= carry;
    cell = octave.cell.xyz + ivec3(whole) + ivec3(carry);
}

void terrain_place(TerrainOctave octave, dvec3 d, out ivec3 cell, out dvec3 fraction) {
    dvec3 t = d * double(octave.fraction_hi.w) + (dvec3(octave.fraction_hi.xyz) + dvec3(octave.fraction_lo.xyz));
    dvec3 whole = floor(t);
    fraction = t - whole;
    cell = octave.cell.xyz + ivec3(whole);
}

// Noise of an octave at offset d: xyz gradient by metres, w value.
vec4 terrain_noise(TerrainOctave octave, vec3 d) {
    ivec3 cell;
    vec3 fraction;
    terrain_place(octave, d, cell, fraction);
    vec4 n = gradient_noise(cell, fraction);
    n.xyz *= octave.fraction_hi.w;
    return n;
}

// The same where the offset is too long for a float: thousands of kilometres, and a warp.
vec4 terrain_noise(TerrainOctave octave, dvec3 d) {
    ivec3 cell;
    dvec3 fraction;
    terrain_place(octave, d, cell, fraction);
    vec4 n = gradient_noise(cell, vec3(fraction));
    n.xyz *= octave.fraction_hi.w;
    return n;
}

// Value and gradient apart, the value as precise as the offset.
double terrain_noise(TerrainOctave octave, dvec3 d, out vec3 gradient) {
    ivec3 cell;
    dvec3 fraction;
    terrain_place(octave, d, cell, fraction);
    double n = gradient_noise_double(cell, fraction, gradient);
    gradient *= octave.fraction_hi.w;
    return n;
}

float terrain_noise(TerrainOctave octave, vec3 d, out vec3 gradient) {
    vec4 n = terrain_noise(octave, d);
    gradient = n.xyz;
    return n.w;
}

vec3 terrain_warp(TerrainOctave octave, vec3 d, out mat3 jacobian) {
    ivec3 cell;
    vec3 fraction;
    terrain_place(octave, d, cell, fraction);
    vec3 w = vector_noise(cell, fraction, jacobian);
    jacobian *= octave.fraction_hi.w;
    return w;
}

dvec3 terrain_warp(TerrainOctave octave, dvec3 d, out mat3 jacobian) {
    ivec3 cell;
    dvec3 fraction;
    terrain_place(octave, d, cell, fraction);
    dvec3 w = vector_noise_double(cell, fraction, jacobian);
    jacobian *= octave.fraction_hi.w;
    return w;
}

#include "terrain/height_sources.glsl"

// The warps, continents and belts.
struct TerrainBroad {
    TERRAIN_REAL3 w1, near, far;   // near: D warped by w2, far: by both
    mat3 j1;                       // of w1
    mat3 to_near, to_far;          // of near and far
    TERRAIN_REAL2 fields;          // c and b
    vec3 dc, db;
};

TerrainBroad terrain_broad(TERRAIN_PLACE D) {
    TerrainBroad t;
    vec2 warp_m = terrain_table.warp_m;

    // Warps of both scales, as differences from the anchor's.
    mat3 j2;
    TERRAIN_REAL3 d = TERRAIN_REAL3(D);
    t.w1 = terrain_warp(terrain_table.octaves[0], d, t.j1);
    TERRAIN_REAL3 w2 = terrain_warp(terrain_table.octaves[1], d, j2);
    t.near = d + TERRAIN_REAL(warp_m.y)
        * (w2 - (TERRAIN_REAL3(terrain_table.warp_hi[1].xyz) + TERRAIN_REAL3(terrain_table.warp_lo[1].xyz)));
    t.far = t.near + TERRAIN_REAL(warp_m.x)
        * (t.w1 - (TERRAIN_REAL3(terrain_table.warp_hi[0].xyz) + TERRAIN_REAL3(terrain_table.warp_lo[0].xyz)));
    t.to_near = mat3(1.0) + warp_m.y * j2;
    t.to_far = t.to_near + warp_m.x * t.j1;

    // Continents and belts.
    t.fields = TERRAIN_REAL2(0.0);
    t.dc = vec3(0.0);
    t.db = vec3(0.0);
    int o = TERRAIN_FIELD;
    do {
        vec2 weights = terrain_table.octaves[o].weights.xy;
        vec3 g;
        t.fields += TERRAIN_REAL2(weights) * terrain_noise(terrain_table.octaves[o], t.far, g);
        t.dc += weights.x * g;
        t.db += weights.y * g;
    } while (++o < TERRAIN_LAYER);
    t.dc = t.dc * t.to_far;
    t.db = t.db * t.to_far;
    return t;
}

// D: the foot on the reference sphere minus the anchor's foot. spacing_m: distance of vertices there. Heights hold all
// layers that the spacing can show, so that vertices lie on the true surface; gradients are band-limited to the
// spacing.
TerrainPoint terrain_point(TerrainBroad broad, TERRAIN_PLACE D, float spacing_m, out double height_m) {
    TerrainConstants k = terrain_table.constants;
    TERRAIN_REAL3 near = broad.near;
    mat3 to_near = broad.to_near;

    // Layers: s of the ranges, z of the relief, in metres; seen_z is what of z the gradient's band shows.
    int layers = terrain_table.layers.x, warped = terrain_table.layers.y;
    int shapes = min(TERRAIN_SHAPE_LAYERS, layers);
    TERRAIN_REAL2 shape_exact = TERRAIN_REAL2(0.0);  // a and b of s
    // of layers that make ranges; below the samples of a height map they are relief
    TERRAIN_REAL broad_z = TERRAIN_REAL(0.0);
    float z = 0.0, seen_z = 0.0;
    vec3 da = vec3(0.0), db = vec3(0.0), dz = vec3(0.0);   // of a, b and z
    int i = 0;
    if (i < shapes) do {
        TerrainOctave octave = terrain_table.octaves[TERRAIN_LAYER + i];
        vec3 g;
        TERRAIN_REAL n = terrain_noise(octave, near, g);
        TERRAIN_REAL ridge = terrain_ridge(n, TERRAIN_REAL(octave.weights.z)),
            v = TERRAIN_REAL(octave.weights.x) * ridge;
        float weight = terrain_layer_weight(octave.fraction_lo.w, spacing_m);
        g *= weight * terrain_ridge_slope(float(n), octave.weights.z);
        vec3 dv = octave.weights.x * g;
#ifdef TERRAIN_MAPPED
        broad_z += TERRAIN_REAL(octave.weights.y) * ridge;
        seen_z += weight * octave.weights.y * float(ridge);
        dz += octave.weights.y * g;
#endif
        bool gating = i < TERRAIN_GATING_LAYERS;
        shape_exact += gating ? TERRAIN_REAL2(v, 0.0) : TERRAIN_REAL2(0.0, v);
        da += gating ? dv : vec3(0.0);
        db += gating ? vec3(0.0) : dv;
    } while (++i < shapes);
#ifdef TERRAIN_CANONICAL
    int warped_end = warped;
#else
    int warped_end = min(terrain_layers_above(0.0625 * spacing_m), warped);   // shorter ones weigh nothing
#endif
    if (i < warped_end) do {
        TerrainOctave octave = terrain_table.octaves[TERRAIN_LAYER + i];
        vec4 n = terrain_noise(octave, near);
        float v = octave.weights.y * terrain_ridge(n.w, octave.weights.z);
        float weight = terrain_layer_weight(octave.fraction_lo.w, spacing_m);
        z += v * terrain_height_weight(octave.fraction_lo.w, spacing_m);
        seen_z += weight * v;
        dz += weight * octave.weights.y * terrain_ridge_slope(n.w, octave.weights.z) * n.xyz;
    } while (++i < warped_end);
    dz = dz * to_near;
    int smooth_end = max(terrain_layers_above(2.0 * spacing_m), warped);
#ifdef TERRAIN_CANONICAL
    int end = layers;
#else
    int end = max(terrain_layers_above(0.0625 * spacing_m), smooth_end);
#endif
    i = warped;
    if (i < smooth_end) do {
        TerrainOctave octave = terrain_table.octaves[TERRAIN_LAYER + i];
        vec4 n = terrain_noise(octave, D);
        float v = octave.weights.y * terrain_ridge(n.w, octave.weights.z);
        float weight = terrain_layer_weight(octave.fraction_lo.w, spacing_m);
        z += v;
        seen_z += weight * v;
        dz += weight * octave.weights.y * terrain_ridge_slope(n.w, octave.weights.z) * n.xyz;
    } while (++i < smooth_end);
    if (i < end) do {
        TerrainOctave octave = terrain_table.octaves[TERRAIN_LAYER + i];
        ivec3 cell;
        TERRAIN_PLACE fraction;
        terrain_place(octave, D, cell, fraction);
        z += octave.weights.y * terrain_ridge(gradient_noise_value(cell, vec3(fraction)), octave.weights.z)
            * terrain_height_weight(octave.fraction_lo.w, spacing_m);
    } while (++i < end);

    vec4 dug = vec4(0.0), rougher;
    double added = terrain_craters(D, spacing_m, dug);
#ifdef TERRAIN_MAPPED
    added += terrain_mapped(terrain_foot(D), spacing_m, dug, rougher);
#else
    rougher = vec4(0.0);
#endif

    TerrainPoint point;
    TERRAIN_REAL h = terrain_surface(k, broad.w1.x, broad.w1.y, broad.w1.z, broad.fields.x, broad.fields.y,
        shape_exact.x, shape_exact.y, broad_z + TERRAIN_REAL(z), TERRAIN_REAL(added), TERRAIN_REAL(rougher.w));
    height_m = double(h);
    point.dh = float(h - (TERRAIN_REAL(terrain_table.height_m.x) + TERRAIN_REAL(terrain_table.height_m.y)));

    vec3 w1 = vec3(broad.w1);
    vec2 fields = vec2(broad.fields), shape = vec2(shape_exact);
    TerrainSurfaceSlopes t = terrain_surface_slopes(k, w1.x, w1.y, w1.z, fields.x, fields.y, shape.x, shape.y,
        float(broad_z) + z, float(added), rougher.w, seen_z);
    vec3 slope = vec3(t.by_w1x, t.by_w1y, t.by_w1z) * broad.j1 + t.by_c * broad.dc + t.by_b * broad.db
        + (t.by_sa * da + t.by_sb * db) * to_near + t.by_z * dz + t.by_added * dug.xyz + t.by_rougher * rougher.xyz;
    vec3 up = terrain_table.up.xyz + vec3(D) / terrain_table.up.w;
    point.gradient = slope - up * dot(up, slope);
    point.roughness = t.by_z;
    float moisture = terrain_table.map.z > 0 ? TERRAIN_COLORED_MOISTURE : 0.5 - 0.6 * w1.z + 0.2 * w1.y;
    point.moisture = clamp(moisture - TERRAIN_DUG_DRY * dug.w, 0.0, 1.0);
    point.mountains = t.on_land;
    return point;
}

TerrainPoint terrain_point(TERRAIN_PLACE D, float spacing_m, out double height_m) {
    return terrain_point(terrain_broad(D), D, spacing_m, height_m);
}

TerrainPoint terrain_point(TERRAIN_PLACE D, float spacing_m) {
    double height_m;
    return terrain_point(D, spacing_m, height_m);
}

// What terrain_point's gradient left out between the vertices' spacing and the pixel's footprint: the layers'
// gradients, each by the difference of its weights. roughness: interpolated from the vertices. The ranges' own layers
// (131..16 km) do not hang on roughness alone; where vertices are tens of kilometres apart they come in by an estimate.
vec3 terrain_detail_gradient(vec3 D, float roughness, float spacing_vertex_m, float footprint_m) {
    int warped = terrain_table.layers.y;
    int begin = max(terrain_layers_above(4.0 * spacing_vertex_m), 0);
    int end = terrain_layers_above(2.0 * footprint_m);
    int warped_end = min(end, warped);
    vec3 sum = vec3(0.0);
    mat3 to_near = mat3(1.0);
    vec3 place = D;
    if (begin < warped_end) {
        mat3 j2;
        vec3 w2 = terrain_warp(terrain_table.octaves[1], D, j2);
        place += terrain_table.warp_m.y * ((w2 - terrain_table.warp_hi[1].xyz) - terrain_table.warp_lo[1].xyz);
        to_near += terrain_table.warp_m.y * j2;
    }
    float range_m = 1.8 * max(1.0 - 0.2 / max(roughness, 1e-3), 0.0) * terrain_table.constants.range_m;
    int i = begin;
    if (i < warped_end) do {
        TerrainOctave octave = terrain_table.octaves[TERRAIN_LAYER + i];
        float weight = terrain_layer_weight(octave.fraction_lo.w, footprint_m)
            - terrain_layer_weight(octave.fraction_lo.w, spacing_vertex_m);
        vec4 n = terrain_noise(octave, place);
        sum += weight * (octave.weights.y + octave.weights.x * range_m) * terrain_ridge_slope(n.w, octave.weights.z)
            * n.xyz;
    } while (++i < warped_end);
    sum = sum * to_near;
    i = max(begin, warped);
    if (i < end) do {
        TerrainOctave octave = terrain_table.octaves[TERRAIN_LAYER + i];
        float weight = terrain_layer_weight(octave.fraction_lo.w, footprint_m)
            - terrain_layer_weight(octave.fraction_lo.w, spacing_vertex_m);
        vec4 n = terrain_noise(octave, D);
        sum += weight * octave.weights.y * terrain_ridge_slope(n.w, octave.weights.z) * n.xyz;
    } while (++i < end);
    vec3 up = terrain_table.up.xyz + D / terrain_table.up.w;
    return roughness * (sum - up * dot(up, sum));
}
