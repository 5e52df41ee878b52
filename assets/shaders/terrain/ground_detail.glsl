// Relief between the vertices' spacing and the pixel's footprint: what the mesh's normals leave out, and, from the very
// same noise, the variation of the ground's colour. Below the shortest layer the octaves go on as grain.
// Costs an octave of noise for each factor of two between spacing and footprint (four or five), a warp and two octaves
// of broad patches. Loops test at their end: on software GPUs a turn with no pixel left costs as much as any other.
#include "generated/terrain_material_block.glsl"
#include "generated/terrain_steps.glsl"
#include "generated/terrain_table.glsl"
#include "common/nested_noise.glsl"

struct GroundDetail {
    // of the terrain's own layers, metres per metre, at roughness 1 (may point out of the tangent plane)
    vec3 gradient;
    vec3 grain;     // of octaves shorter than its shortest layer, each as steep as the shortest
    // For colours: of the place and the footprint alone, so that a mesh that is chosen anew changes none.
    float fine;     // noise of 3 to 20 footprints, variance about 1
    float broad;    // noise of about 40 footprints, variance about 1
    float shore;    // noise of a kilometre, variance about 1
};

const int DETAIL_MOST = 28;
const int SHORE_OCTAVE = 14;   // NESTED_BASE_M times 2 to this: 1024 m
const float DETAIL_FINE = 6.0;  // footprints: noise four times as long as this is no part of the fine one

// place: from the anchor's foot, in space.
float noise_of_space(vec3 place, int k) {
    ivec3 cell;
    vec3 fraction;
    float frequency;
    nested_place(terrain_material_block.anchor.cell, terrain_material_block.anchor.fraction, place, clamp(k, 0, 29),
        cell, fraction, frequency);
    return gradient_noise_value(cell, fraction) / NESTED_RMS;
}

// spacing: of the vertices; footprint: of the pixel, metres. falls: slope that the vertices show, which gullies follow.
// real: what there is of real ground, whose relief begins below its samples.
GroundDetail ground_detail(vec3 D, float roughness, float spacing, float footprint
#ifdef TERRAIN_ERODED
    , vec3 falls, vec3 up
#endif
#ifdef TERRAIN_TILED
    , RealGround real
#endif
) {
    ivec3 cell;
    vec3 fraction;
    int layers = terrain_material_block.layer_count, warped = terrain_material_block.warped_layers;
    float first_m = terrain_material_block.layers[0].wavelength_m;
    int begin = int(clamp(ceil(log2(first_m / (4.0 * max(spacing, DETAIL_FINE * footprint)))), 0.0,
        float(DETAIL_MOST)));
    int end = int(clamp(ceil(log2(first_m / (2.0 * footprint))), 0.0, float(DETAIL_MOST)));

    ReliefWarp warp = terrain_material_block.warp;
    mat3 jacobian;
    lattice_place(warp.cell, warp.fraction, warp.frequency_per_m, D, cell, fraction);
    vec3 near = D + warp.amplitude_m * (vector_noise(cell, fraction, jacobian) - warp.value);
    mat3 to_near = mat3(1.0) + (warp.amplitude_m * warp.frequency_per_m) * jacobian;

    GroundDetail sum = GroundDetail(vec3(0.0), vec3(0.0), 0.0, 0.0, 0.0);
    vec3 bent = vec3(0.0);
    float power = 0.5;
    float in_ranges = max(1.0 - 0.2 / max(roughness, 1e-3), 0.0);
#ifdef TERRAIN_ERODED
    Gullies gullies = Gullies(falls, mat3(0.0), up, roughness, terrain_table.erosion, 0.0, 0.0, vec3(0.0));
#endif
    int i = begin;
    do {
        int known = min(i, layers - 1), further = i - known;
        float finer = exp2(float(further));
        ReliefLayer layer = terrain_material_block.layers[known];
        vec3 within = layer.fraction * finer, whole = floor(within);
        vec3 rest = within - whole + fract(vec3(0.618034, 0.754878, 0.569840) * float(further));
        float frequency = layer.frequency_per_m * finer;
        lattice_place((layer.cell << further) + ivec3(whole), rest, frequency, i < warped ? near : D, cell, fraction);
        vec4 n = gradient_noise(cell, fraction);
        float wavelength = layer.wavelength_m / finer;
        float shown = terrain_layer_weight(wavelength, footprint);
        float weight = shown - terrain_layer_weight(wavelength, spacing);
        float fine = shown - terrain_layer_weight(wavelength, DETAIL_FINE * footprint);
        float amplitude_m = layer.amplitude_m + layer.range_amplitude_m * in_ranges;
#ifdef TERRAIN_TILED
        if (real.rest < 1.0) amplitude_m *= mix(i < warped ? 0.0 : real_below(real, wavelength), 1.0, real.rest);
#endif
        vec3 g = (weight * frequency * terrain_ridge_slope(n.w, layer.ridge) * amplitude_m / finer) * n.xyz;
#ifdef TERRAIN_ERODED
        gullies.strength = i >= GULLY_FIRST && i < GULLY_END ? terrain_table.erosion : 0.0;
#ifdef TERRAIN_TILED
        if (i >= GULLY_END && i < GULLY_END_BELOW_SAMPLES) gullies.strength = terrain_table.erosion * (1.0 - real.rest);
#endif
        gullies.d_falls = mat3(0.0);   // how the slope turns within a furrow shows too little
        Gully gully = gully_layer(cell, fraction, wavelength, amplitude_m, mat3(1.0), gullies);
        g = mix(g, (weight * amplitude_m) * gully.d_wave, gully.share);
#endif
        sum.fine += fine * n.w;
        power += fine * fine;
        bent += i < warped ? g : vec3(0.0);
        sum.gradient += i < warped || further > 0 ? vec3(0.0) : g;
        sum.grain += further > 0 ? g : vec3(0.0);
    } while (++i < end);
    sum.gradient += bent * to_near;
    sum.fine *= inversesqrt(power) / NESTED_RMS;

    // Broad patches: two wavelengths, a factor of eight apart, the longer one taking over as the footprint grows.
    float octave = log2(max(20.0 * footprint / NESTED_BASE_M, 1.0)) / 3.0;
    float low = min(floor(octave), 8.0), t = clamp(octave - low, 0.0, 1.0);
    t = t * t * (3.0 - 2.0 * t);
    int k = 3 * int(low) + 1;
    i = 0;
    do {
        float frequency;
        nested_place(terrain_material_block.anchor.cell, terrain_material_block.anchor.fraction, D, k, cell,
            fraction, frequency);
        sum.broad += (i == 0 ? 1.0 - t : t) * gradient_noise_value(cell, fraction);
        k += 3;
    } while (++i < 2);
    sum.broad *= inversesqrt(1.0 - 2.0 * t * (1.0 - t)) / NESTED_RMS;
    sum.shore = noise_of_space(D, SHORE_OCTAVE);
    return sum;
}

// Slopes between which colours go over from noise of the map, which a steep slope draws out, to noise of space.
const vec2 CLIFF_SLOPE = vec2(0.25, 0.65);

// slope: of all that shows, so that a mesh that is chosen anew changes no colour.
void ground_cliffs(inout GroundDetail detail, vec3 place, float slope, float footprint) {
    float share = clamp((slope - CLIFF_SLOPE.x) / (CLIFF_SLOPE.y - CLIFF_SLOPE.x), 0.0, 1.0);
    if (share <= 0.0) return;
    // Three octaves from 3 footprints on, the outer two taking turns as the footprint grows.
    float octave = log2(max(3.0 * footprint / NESTED_BASE_M, 1.0)), t = fract(octave);
    int low = int(octave);
    float fine = (1.0 - t) * noise_of_space(place, low) + noise_of_space(place, low + 1)
        + t * noise_of_space(place, low + 2);
    fine *= inversesqrt(1.0 + t * t + (1.0 - t) * (1.0 - t));
    detail.fine = mix(detail.fine, fine, share) * inversesqrt(share * share + (1.0 - share) * (1.0 - share));
}
