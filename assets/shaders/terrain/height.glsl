// The height of the ground, its gradient and roughness, around an anchor: the GPU's side of systems/terrain/height*.py
// (height_surface.py has the statements of its point-wise part). Point-wise function of a few noises, see
// docs/terrain-height.md:
//   w1 w2 warps;  c continents, b belts (warped by both);  s ranges, z relief (the layers; the ridged ones warped by
//   w2)
// Coordinates: D = foot on the reference sphere minus the anchor's, metres, planet axes, f32. An octave's lattice place
// is the anchor's (cell and fraction from float64) plus D * frequency, exact products: frequencies are powers of two.
// All is float. A millimetre is 1e-7 of a 9 km relief, and belts magnify rounding: so warps, continents, belts, ranges
// and the point-wise part are evaluated as changes from the anchor (terrain/height_change.glsl), whose errors are
// relative to the offset from it. The relief, which is a few hundred metres, is the sum of its layers.
//
// TERRAIN_CANONICAL: the table is around the planet's centre, places are in fixed point and what is broad in pairs of
// floats (terrain/height_fixed.glsl), so that heights are functions of nothing but the place, with all layers whatever
// the spacing: canonical_height.glsl.
#include "contract/height_sources.glsl"
#ifdef TERRAIN_CANONICAL
#include "common/noise_fixed.glsl"
#endif
#include "common/noise.glsl"
#include "generated/terrain_table.glsl"
#include "generated/terrain_surface.glsl"

#ifdef TERRAIN_CANONICAL
#define TERRAIN_PLACE Fixed3
#define TERRAIN_REAL Pair
#define TERRAIN_REAL2 Pair2
#define TERRAIN_REAL3 Pair3
#define TERRAIN_NUMBER(a) pair(a)
#define TERRAIN_SUM(a, b) pair_add(a, b)
#define TERRAIN_PRODUCT(a, b) pair_mul(a, b)
#define TERRAIN_SINGLE(a) (a).high
#else
#define TERRAIN_PLACE vec3
#define TERRAIN_REAL float
#define TERRAIN_REAL2 vec2
#define TERRAIN_REAL3 vec3
#define TERRAIN_NUMBER(a) (a)
#define TERRAIN_SUM(a, b) ((a) + (b))
#define TERRAIN_PRODUCT(a, b) ((a) * (b))
#define TERRAIN_SINGLE(a) (a)
#endif

struct TerrainPoint {
    float dh;         // height above the anchor's height, metres
    vec3 gradient;    // surface gradient of the height at the foot: tangent vector in planet axes, metres per metre
    float roughness;  // multiplier of the layers, 0..1.2: interpolate it, hand it to ground_detail
    float moisture;   // 0 dry .. 1 wet, for materials
    float mountains;  // 0..1 where ranges stand, for materials
};

const float TERRAIN_DUG_DRY = 0.3;  // what fresh craters take off the moisture: they show what lies below dark plains
const float TERRAIN_BANK_WET = 0.4; // what banks of rivers and lakes add to it, where Cover.riparian is 1
const float TERRAIN_COLORED_MOISTURE = 0.45;  // where a colour map says what the ground looks like

// Share of a layer in heights: only layers shorter than an eighth of the spacing fade, which no vertex can show.
float terrain_height_weight(float wavelength_m, float spacing_m) {
#ifdef TERRAIN_CANONICAL
    return 1.0;
#endif
    return terrain_smoothstep(wavelength_m / spacing_m * 16.0 - 1.0);
}

// How many layers are longer than a length.
int terrain_layers_above(float length_m) {
    float first_m = terrain_table.layers[0].lattice.wavelength_m;
    return int(clamp(ceil(log2(first_m / length_m)), 0.0, float(terrain_table.layer_count)));
}

// How many layers weigh anything in heights.
int terrain_shown_layers(float spacing_m) {
#ifdef TERRAIN_CANONICAL
    return terrain_table.layer_count;
#else
    return terrain_layers_above(0.0625 * spacing_m);
#endif
}

// Where d is in an octave's lattice.
#ifdef TERRAIN_CANONICAL
void terrain_place(TerrainLattice lattice, Fixed3 d, out ivec3 cell, out uvec3 fraction) {
    int shift = (floatBitsToInt(lattice.wavelength_m) - floatBitsToInt(terrain_table.fixed_unit_m)) >> 23;
    Fixed3 place = fixed_add(fixed_coarser(d, shift), Fixed3(lattice.cell, uvec3(lattice.fraction * 16777216.0) << 8));
    cell = place.whole;
    fraction = place.part;
}

void terrain_place(TerrainLattice lattice, Fixed3 d, out ivec3 cell, out vec3 fraction) {
    uvec3 exact;
    terrain_place(lattice, d, cell, exact);
    fraction = noise_single(exact);
}

vec3 terrain_offset(Fixed3 d) { return fixed_pair(d).high * terrain_table.fixed_unit_m; }
#else
void terrain_place(TerrainLattice lattice, vec3 d, out ivec3 cell, out vec3 fraction) {
    lattice_place(lattice.cell, lattice.fraction, lattice.frequency_per_m, d, cell, fraction);
}

vec3 terrain_offset(vec3 d) { return d; }
#endif

// Noise of an octave at offset d: xyz gradient by metres, w value.
vec4 terrain_noise(TerrainLattice lattice, TERRAIN_PLACE d) {
    ivec3 cell;
    vec3 fraction;
    terrain_place(lattice, d, cell, fraction);
    vec4 n = gradient_noise(cell, fraction);
    n.xyz *= lattice.frequency_per_m;
    return n;
}

float terrain_noise_value(TerrainLattice lattice, TERRAIN_PLACE d) {
    ivec3 cell;
    vec3 fraction;
    terrain_place(lattice, d, cell, fraction);
    return gradient_noise_value(cell, fraction);
}

#ifdef TERRAIN_CANONICAL
#include "terrain/height_fixed.glsl"
#else
#include "terrain/height_change.glsl"
#endif

#include "terrain/height_sources.glsl"
#ifdef TERRAIN_RIVERS
#include "terrain/rivers.glsl"
#endif

#ifdef TERRAIN_ERODED
#include "terrain/falls.glsl"
#endif

// Domain warps, continents and belts: w1 and fields as changes from the anchor's.
struct TerrainBroad {
    TERRAIN_REAL3 w1;
    TERRAIN_PLACE near, far;       // near: D warped by w2, far: by both
    mat3 j1;                       // of w1, 1/m
    mat3 to_near, to_far;          // of near and far
    TERRAIN_REAL2 fields;          // c and b
    vec3 dc, db;                   // 1/m
};

// Domain warp (Perlin 1985, "An Image Synthesizer": noise moves the place at which noise is asked): metres, of both
// scales, as differences from the anchor's.
void terrain_warp_domain(TERRAIN_PLACE d, inout TerrainBroad t) {
    TerrainWarp wide = terrain_table.wide_warp, narrow = terrain_table.narrow_warp;
    mat3 j2;
    t.near = d;
    terrain_warp_place(t.near, narrow, d, j2);
    t.far = t.near;
    t.w1 = terrain_warp_place(t.far, wide, d, t.j1);
    t.to_near = mat3(1.0) + narrow.amplitude_m * j2;
    t.to_far = t.to_near + wide.amplitude_m * t.j1;
}

// Continents and belts: weighted octaves of noise at the warped place (fractional Brownian motion), without unit.
void terrain_fields(inout TerrainBroad t) {
    t.fields = TERRAIN_NUMBER(vec2(0.0));
    t.dc = vec3(0.0);
    t.db = vec3(0.0);
    int o = 0;
    do {
        vec2 weights = terrain_table.fields[o].weights;
        vec3 g;
        TERRAIN_REAL n = terrain_change(terrain_table.fields[o].lattice, t.far, g);
        t.fields = TERRAIN_SUM(t.fields, TERRAIN_PRODUCT(weights, n));
        t.dc += weights.x * g;
        t.db += weights.y * g;
    } while (++o < TERRAIN_FIELDS);
    t.dc = t.dc * t.to_far;
    t.db = t.db * t.to_far;
}

TerrainBroad terrain_broad(TERRAIN_PLACE D) {
    TerrainBroad t;
    terrain_warp_domain(D, t);
    terrain_fields(t);
    return t;
}

// The layers' sums: s of the ranges, z of the relief. s and range_z as changes from the anchor's.
struct TerrainRelief {
    TERRAIN_REAL2 s;            // of the layers that gate the next ones, and of those next ones
    TERRAIN_REAL range_z;       // metres, of layers that make ranges: below the samples of a height map they are relief
    float z;                    // metres, of the others
    float seen_z;               // metres: what of range_z + z the gradients' band shows
    vec3 d_gating, d_gated;     // of s, by the warped place, 1/m
    vec3 dz;                    // what of z is seen, metres per metre
};

// The layers that make ranges: ridged, and in full at any spacing.
void terrain_range_layers(TERRAIN_PLACE near, float spacing_m, int end, inout TerrainRelief sum) {
    int i = 0;
    if (i < end) do {
        TerrainLayer layer = terrain_table.layers[i];
        vec3 g;
        TERRAIN_REAL n = terrain_change(layer.lattice, near, g), ridge = terrain_layer_change(layer, n);
        float whole = layer.lattice.value + TERRAIN_SINGLE(n);
        float weight = terrain_layer_weight(layer.lattice.wavelength_m, spacing_m);
        g *= weight * terrain_ridge_slope(whole, layer.ridge);
#ifdef TERRAIN_MAPPED
        sum.range_z = TERRAIN_SUM(sum.range_z, TERRAIN_PRODUCT(layer.amplitude_m, ridge));
        sum.seen_z += weight * layer.amplitude_m * terrain_ridge(whole, layer.ridge);
        sum.dz += layer.amplitude_m * g;
#endif
        vec2 weights = i < TERRAIN_GATING_LAYERS ? vec2(layer.range_weight, 0.0) : vec2(0.0, layer.range_weight);
        sum.s = TERRAIN_SUM(sum.s, TERRAIN_PRODUCT(weights, ridge));
        sum.d_gating += weights.x * g;
        sum.d_gated += weights.y * g;
    } while (++i < end);
}

#ifdef TERRAIN_ERODED
// Adds layer i of gullies, asked at place `at`; to_at: how that changes with the place. d_place: what of z is seen, by
// the place.
void terrain_add_gully(int i, TERRAIN_PLACE at, mat3 to_at, float spacing_m, inout Gullies gullies,
    inout TerrainRelief sum, inout vec3 d_place) {
    TerrainLayer layer = terrain_table.layers[i];
    ivec3 cell;
    vec3 fraction;
    terrain_place(layer.lattice, at, cell, fraction);
    vec4 n = gradient_noise(cell, fraction);
    n.xyz = (n.xyz * layer.lattice.frequency_per_m) * to_at;
    Gully gully = gully_layer(cell, fraction, layer.lattice.wavelength_m, layer.amplitude_m, to_at, gullies);
    float plain = terrain_ridge(n.w, layer.ridge), v = layer.amplitude_m * mix(plain, gully.wave, gully.share);
    float weight = terrain_layer_weight(layer.lattice.wavelength_m, spacing_m);
    float shown = terrain_height_weight(layer.lattice.wavelength_m, spacing_m);
    sum.z += v * shown;
    sum.seen_z += weight * v;
    float furrow = layer.amplitude_m * gully.share * gully.wave;
    gullies.furrows += shown * furrow;
    gullies.seen_furrows += weight * furrow;
    gullies.d_furrows += (weight * layer.amplitude_m) * (gully.share * gully.d_wave + gully.d_share * gully.wave);
    d_place += weight * layer.amplitude_m * ((1.0 - gully.share) * terrain_ridge_slope(n.w, layer.ridge) * n.xyz
        + gully.share * gully.d_wave + gully.d_share * (gully.wave - plain));
}
#endif

// Adds a layer of relief with noise n (xyz gradient, w value). share: of it that is in heights.
void terrain_add_layer(TerrainLayer layer, vec4 n, float spacing_m, float share, inout TerrainRelief sum) {
    float v = layer.amplitude_m * terrain_ridge(n.w, layer.ridge);
    float weight = terrain_layer_weight(layer.lattice.wavelength_m, spacing_m);
    sum.z += v * share;
    sum.seen_z += weight * v;
    sum.dz += weight * layer.amplitude_m * terrain_ridge_slope(n.w, layer.ridge) * n.xyz;
}

// The layers of relief between those of ranges and the shortest that the spacing shows: warped ones first; then those
// with a gradient; of those shorter than two spacings the height alone.
void terrain_relief_layers(TerrainBroad broad, TERRAIN_PLACE D, float spacing_m, int begin,
#ifdef TERRAIN_ERODED
    inout Gullies gullies,
#endif
    inout TerrainRelief sum) {
    int warped = terrain_table.warped_layers, shown = terrain_shown_layers(spacing_m), i = begin;
#ifdef TERRAIN_ERODED
    int warped_end = min(shown, GULLY_FIRST);
#else
    int warped_end = min(shown, warped);
#endif
    if (i < warped_end) do {
        TerrainLayer layer = terrain_table.layers[i];
        terrain_add_layer(layer, terrain_noise(layer.lattice, broad.near), spacing_m,
            terrain_height_weight(layer.lattice.wavelength_m, spacing_m), sum);
    } while (++i < warped_end);
    sum.dz = sum.dz * broad.to_near;
#ifdef TERRAIN_ERODED
    vec3 d_place = vec3(0.0);
    int gully_end = min(shown, GULLY_END);
    i = GULLY_FIRST;
    if (i < gully_end) do {
        bool bent = i < warped;
        TERRAIN_PLACE at = D;
        mat3 to_at = mat3(1.0);
        if (bent) {
            at = broad.near;
            to_at = broad.to_near;
        }
        terrain_add_gully(i, at, to_at, spacing_m, gullies, sum, d_place);
    } while (++i < gully_end);
    sum.dz += d_place;
    int smooth_end = max(terrain_layers_above(2.0 * spacing_m), GULLY_END);
    i = GULLY_END;
#else
    int smooth_end = max(terrain_layers_above(2.0 * spacing_m), warped);
    i = warped;
#endif
    if (i < smooth_end) do {
        TerrainLayer layer = terrain_table.layers[i];
        terrain_add_layer(layer, terrain_noise(layer.lattice, D), spacing_m, 1.0, sum);
    } while (++i < smooth_end);
    int end = max(shown, smooth_end);
    if (i < end) do {
        TerrainLayer layer = terrain_table.layers[i];
        sum.z += layer.amplitude_m * terrain_ridge(terrain_noise_value(layer.lattice, D), layer.ridge)
            * terrain_height_weight(layer.lattice.wavelength_m, spacing_m);
    } while (++i < end);
}

TerrainRelief terrain_relief(TerrainBroad broad, TERRAIN_PLACE D, float spacing_m
#ifdef TERRAIN_ERODED
    , inout Gullies gullies
#endif
) {
    TerrainRelief sum = TerrainRelief(TERRAIN_NUMBER(vec2(0.0)), TERRAIN_NUMBER(0.0), 0.0, 0.0, vec3(0.0), vec3(0.0),
        vec3(0.0));
    int ranges = min(TERRAIN_SHAPE_LAYERS, terrain_table.layer_count);
    terrain_range_layers(broad.near, spacing_m, ranges, sum);
#ifdef TERRAIN_ERODED
    terrain_relief_layers(broad, D, spacing_m, ranges, gullies, sum);
#else
    terrain_relief_layers(broad, D, spacing_m, ranges, sum);
#endif
    return sum;
}

// The surface's gradient in space, metres per metre, by the chain rule.
vec3 terrain_slope(TerrainSurfaceSlopes t, TerrainBroad broad, TerrainRelief relief, TerrainSources sources) {
    return vec3(t.by_w1x, t.by_w1y, t.by_w1z) * broad.j1 + t.by_c * broad.dc + t.by_b * broad.db
        + (t.by_sa * relief.d_gating + t.by_sb * relief.d_gated) * broad.to_near + t.by_z * relief.dz
        + t.by_added * sources.gradient + t.by_rougher * sources.d_rougher;
}

// 0 dry .. 1 wet: the wide warp's other components, so that it costs no noise.
float terrain_moisture(vec3 w1, float dug) {
    float moisture = terrain_table.color.cells > 0 ? TERRAIN_COLORED_MOISTURE : 0.5 - 0.6 * w1.z + 0.2 * w1.y;
    return clamp(moisture - TERRAIN_DUG_DRY * dug, 0.0, 1.0);
}

// Metres above the anchor's height. added: by craters and map, as a change from the anchor; cut: by rivers; furrows:
// metres of relief that are gullies.
TERRAIN_REAL terrain_height(TerrainBroad broad, TerrainRelief relief, TERRAIN_REAL added, float rougher
#ifdef TERRAIN_CARVED
    , TerrainCut cut, float furrows, out TERRAIN_REAL uncarved
#endif
) {
    TerrainConstants k = terrain_table.constants;
    TERRAIN_REAL z = TERRAIN_SUM(relief.range_z, relief.z);
#ifdef TERRAIN_CANONICAL
    TERRAIN_REAL h = terrain_surface(k, PAIR_PART(broad.w1, x), PAIR_PART(broad.w1, y), PAIR_PART(broad.w1, z),
        PAIR_PART(broad.fields, x), PAIR_PART(broad.fields, y), PAIR_PART(relief.s, x), PAIR_PART(relief.s, y), z,
        added, pair(rougher));
#ifdef TERRAIN_CARVED
    uncarved = h;
    float sides = terrain_side_rough(h.high, cut.base, cut.open);
    h = pair_add(terrain_carve(h, pair(cut.base), pair(cut.open), pair(cut.raised)), pair(sides * furrows));
#endif
    return h;
#else
    TerrainAnchor anchor = terrain_table.anchor;
    vec3 w1 = terrain_table.wide_warp.value;
    float dh = terrain_surface_change(k, w1.x, w1.y, w1.z, anchor.fields.x, anchor.fields.y,
        anchor.shapes.x, anchor.shapes.y, anchor.ranges_m, anchor.added_m, 0.0, broad.w1.x, broad.w1.y, broad.w1.z,
        broad.fields.x, broad.fields.y, relief.s.x, relief.s.y, z, added, rougher);
#ifdef TERRAIN_CARVED
    TerrainRivers at = terrain_table.rivers;
    uncarved = at.uncarved_m + dh;
    dh = terrain_carve_change(at.uncarved_m, at.base_m, at.open, at.raised, dh, cut.base, cut.open - at.open,
        cut.raised - at.raised);
    dh += terrain_side_rough(uncarved, at.base_m + cut.base, cut.open) * furrows;
#endif
    return anchor.height_m + dh;
#endif
}

// D: the foot on the reference sphere minus the anchor's foot. spacing_m: distance of vertices there. Heights hold all
// layers that the spacing can show, so that vertices lie on the true surface; gradients are band-limited to the
// spacing. height_m: dh before it is rounded.
TerrainPoint terrain_point(TerrainBroad broad, TERRAIN_PLACE D, float spacing_m, out TERRAIN_REAL height_m) {
    TerrainAnchor anchor = terrain_table.anchor;
    vec3 w1 = terrain_table.wide_warp.value + TERRAIN_SINGLE(broad.w1);
    vec2 fields = anchor.fields + TERRAIN_SINGLE(broad.fields);
    vec3 up = terrain_table.up + terrain_offset(D) / terrain_table.radius_m;
    TerrainSources sources;
    TERRAIN_REAL added = terrain_sources(D, spacing_m, sources);
#ifdef TERRAIN_CARVED
    TERRAIN_REAL uncarved;
    TerrainCut cut = terrain_cut(D);
#endif
    float furrows = 0.0, seen_furrows = 0.0;
    vec3 d_furrows = vec3(0.0);
#ifdef TERRAIN_ERODED
    Gullies gullies = terrain_gullies(broad.near, broad.to_near, up, w1, fields,
        anchor.added_m + TERRAIN_SINGLE(added), sources.rougher,
#ifdef TERRAIN_CARVED
        cut,
#endif
        terrain_shown_layers(spacing_m));
    TerrainRelief relief = terrain_relief(broad, D, spacing_m, gullies);
    furrows = gullies.furrows;
    seen_furrows = gullies.seen_furrows;
    d_furrows = gullies.d_furrows;
#else
    TerrainRelief relief = terrain_relief(broad, D, spacing_m);
#endif
#ifdef TERRAIN_CARVED
    height_m = terrain_height(broad, relief, added, sources.rougher, cut, furrows, uncarved);
#else
    height_m = terrain_height(broad, relief, added, sources.rougher);
#endif

    vec2 s = anchor.shapes + TERRAIN_SINGLE(relief.s);
    TerrainSurfaceSlopes t = terrain_surface_slopes(terrain_table.constants, w1.x, w1.y, w1.z, fields.x, fields.y, s.x,
        s.y, anchor.ranges_m + TERRAIN_SINGLE(relief.range_z) + relief.z, anchor.added_m + TERRAIN_SINGLE(added),
        sources.rougher, relief.seen_z);
    vec3 slope = terrain_slope(t, broad, relief, sources);
    float kept = 1.0, sides = 0.0;
#ifdef TERRAIN_CARVED
    // A valley is a wave as wide as both of its sides.
    float shown = terrain_layer_weight(2.0 * cut.reach, spacing_m);
    vec3 d_base = shown * cut.d_base, d_open = shown * cut.d_open, d_raised = shown * cut.d_raised;
    float base_m = terrain_table.rivers.base_m + cut.base;
    TerrainCarveSlopes by = terrain_carve_slopes(TERRAIN_SINGLE(uncarved), base_m, cut.open, cut.raised);
    TerrainSideRoughSlopes side = terrain_side_rough_slopes(TERRAIN_SINGLE(uncarved), base_m, cut.open);
    slope = (by.by_h + side.by_h * seen_furrows) * slope + (by.by_base + side.by_base * seen_furrows) * d_base
        + (by.by_open + side.by_open * seen_furrows) * d_open + by.by_raised * d_raised
        + side.value * d_furrows;
    kept = by.by_h;
    sides = side.value;
#endif
#ifdef TERRAIN_TILED
    RealGround real = terrain_real(D, spacing_m);
    slope = real.seen_rest * slope + real.d_height + TERRAIN_SINGLE(height_m) * real.d_rest;
    height_m = TERRAIN_SUM(TERRAIN_PRODUCT(real.rest, height_m), real.height);
    vec3 below;
    height_m = TERRAIN_SUM(height_m, TERRAIN_NUMBER(terrain_real_relief(real, D, up, spacing_m, below)));
    slope += below;
    kept *= real.rest;
#endif

    TerrainPoint point;
    point.dh = TERRAIN_SINGLE(height_m);
    point.gradient = slope - up * dot(up, slope);
    point.roughness = t.by_z * kept + sides;
#ifdef TERRAIN_TILED
    point.roughness += real.rough;
#endif
    point.moisture = terrain_moisture(w1, sources.dug);
    // As systems/cover/growth.py has it.
#ifdef TERRAIN_CARVED
    point.moisture = min(point.moisture + TERRAIN_BANK_WET * terrain_table.rivers.wetter * cut.beside, 1.0);
#elif defined(TERRAIN_RIVERS)
    float wetter = TERRAIN_BANK_WET * terrain_table.rivers.wetter;
    if (wetter > 0.0) point.moisture = min(point.moisture + wetter * terrain_beside(D), 1.0);
#endif
    point.mountains = t.on_land;
    return point;
}

TerrainPoint terrain_point(TERRAIN_PLACE D, float spacing_m) {
    TERRAIN_REAL height_m;
    return terrain_point(terrain_broad(D), D, spacing_m, height_m);
}
