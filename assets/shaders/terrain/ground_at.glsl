// What the rules of materials (systems/terrain/materials.py, which says what each value means) know of a place: height,
// slope, climate and chance, broken up by noise whose wavelengths follow the pixel's footprint. What is smaller than a
// pixel counts as a share of it: slopes and heights that the footprint hides enter as a variance, so that the colour of
// a place stays the same from 2 m to 36 000 km. Numbers without a source are chosen by eye.
#include "common/season.glsl"
#include "generated/planet.glsl"
#include "generated/terrain_albedos.glsl"
#include "generated/terrain_ground.glsl"
#include "terrain/ground_detail.glsl"

// 0 below a, 1 above b, straight between them: cheaper than smoothstep, and noise on x hides the corners.
float ramp(float a, float b, float x) {
    return clamp((x - a) * (1.0 / (b - a)), 0.0, 1.0);
}

// 1 at the center, 0 from one width on.
float bell(float x, float center, float inverse_width) {
    float t = (x - center) * inverse_width;
    t = max(1.0 - t * t, 0.0);
    return t * t;
}

// Variance of the slopes of relief shorter than twice a length: a fit to the layers' table.
float hidden_slope_variance(float roughness, float footprint) {
    ReliefSlopes slopes = terrain_material_block.slopes;
    // As components of a vector Mesa keeps the order of the product.
    vec3 relief = vec3(slopes.shortest_per_m, slopes.variance, slopes.per_octave);
    float t = clamp(log2(footprint * relief.x) * relief.z, 0.0, 1.0);
    return roughness * roughness * relief.y * t * t;
}

// Layers of rock: four widths of strata that wave with the noise, each gone where the pixel spans one. Metres; -1..1.
float strata(float height, float wave, float rise_of_pixel) {
    vec4 frequency = terrain_material_block.strata_per_m * vec4(1.0, 6.0, 38.0, 230.0);
    vec4 s = abs(2.0 * fract(height * frequency + wave * vec4(0.05, 0.08, 0.12, 0.16)) - 1.0);
    s = s * s * (3.0 - 2.0 * s) - 0.5;
    vec4 seen = clamp(1.5 - 3.0 * rise_of_pixel * frequency, 0.0, 1.0);
    return dot(s * seen, vec4(0.6, 0.4, 0.35, 0.3));
}

// Peaks of the fine noise are stones, its hollows shrubs or tufts; far away they are a mean tint.
void ground_chance(inout Ground ground, GroundDetail noise) {
    // From far away climate shows more than chance.
    float variation = terrain_material_block.variation * mix(1.0, 0.4, ramp(8.0, 15.0, log2(ground.footprint_m)));
    ground.fine = noise.fine;
    ground.broad = noise.broad;
    ground.region = noise.shore;
    ground.grain = noise.fine * variation;
    ground.patches = noise.broad * variation;
    ground.mixed = 0.7 * ground.patches + 0.5 * ground.grain;
    float spots = ramp(120.0, 6.0, ground.footprint_m) * variation;
    ground.stones = ramp(1.0, 1.6, noise.fine + 0.4 * noise.broad) * spots;
    ground.tufts = ramp(0.6, 1.5, 0.5 * ground.mixed - noise.fine) * spots;
}

void ground_relief(inout Ground ground, vec3 gradient, float shore) {
    float variance = hidden_slope_variance(ground.roughness, ground.footprint_m);
    ground.hidden_slope = sqrt(variance);
    ground.slope = sqrt(dot(gradient, gradient) + variance);
    ground.above_sea_m = ground.height_m - (planet.has_sea ? planet.sea_level_m : -1.0e9);
    // Waves take the sand from some stretches of the coast to others.
    ground.beach_height_m = terrain_material_block.beach_height_m
        * clamp(shore + terrain_material_block.beach_shift, 0.0, 1.0);
    ground.snow_slope = terrain_material_block.snow_slope;
}

// The snow line falls towards the poles as the sun's yearly mean does, about with the sine's square. Wet at the equator
// and in the westerlies, dry under the descending air at 25 degrees (the Hadley cell).
void ground_climate(inout Ground ground, vec3 zenith, vec3 gradient) {
    float sine2 = zenith.z * zenith.z, sine = sqrt(sine2);
    float rise_m = terrain_material_block.snow_line_rise_m * sine2 * (0.4 + 0.6 * sine);
    float line = terrain_material_block.snow_line_m + rise_m;
    ground.latitude_sine = sine;
    ground.mean_warmth = (line - ground.height_m) * terrain_material_block.warmth_per_m;
    ground.warmth = ground.mean_warmth + 0.025 * ground.mixed;
    ground.warmth_per_m = terrain_material_block.warmth_per_m;
    ground.winter = winter_here(terrain_material_block.winter, zenith.z);
    // Ground that rises towards the nearer pole faces the equator.
    ground.sunny = clamp(3.0 * zenith.z * (gradient.z - dot(gradient, zenith) * zenith.z), -1.0, 1.0);
    ground.mean_humidity = terrain_material_block.humidity + 0.9 * ground.moisture + 0.30 * bell(sine, 0.0, 3.6)
        - 0.34 * bell(sine, 0.42, 3.2) + 0.16 * bell(sine, 0.85, 2.2);
    ground.humidity = ground.mean_humidity + 0.10 * ground.mixed;
}

void ground_growth(inout Ground ground) {
    ground.plants = terrain_material_block.plants;
    ground.green = ramp(0.32, 0.50, ground.humidity) * ground.plants;
    // Roots hold soil on slopes that would be bare in a dry or cold place.
    ground.rooted = ground.green * ramp(0.05, 0.3, ground.warmth);
    ground.sanded = ramp(-0.5, 1.3, ground.mixed - 2.5 * ground.humidity + 0.62);
}

// Steep ground: scree first, then rock in layers. Rough ground, as of mountain ranges, turns to rock earlier.
void ground_steepness(inout Ground ground) {
    float bare = terrain_material_block.rock_slope * clamp(1.25 - ground.roughness, 0.5, 1.0)
        * (1.0 + 0.9 * ground.rooted);
    // Bumps of a few metres alone are no cliffs.
    float bumpy = sqrt(hidden_slope_variance(ground.roughness, max(ground.footprint_m, 10.0)));
    ground.steep = (ground.slope - bare) / (0.25 * bare + bumpy) + 0.45 * ground.grain;
    ground.layered = strata(ground.height_m, ground.mixed, ground.footprint_m * (0.1 + ground.slope))
        * terrain_material_block.strata;
}

// gradient: of the visible relief, metres per metre; footprint: what a pixel covers, metres. wooded: where a map lets
// woods stand.
Ground ground_at(
    GroundDetail noise, vec3 zenith, float height, vec3 gradient, float roughness, float moisture, float footprint,
    float wooded
) {
    Ground ground;
    ground.height_m = height;
    ground.roughness = roughness;
    ground.moisture = moisture;
    ground.footprint_m = footprint;
    ground.wooded = wooded;
    ground.barred = ground.silted = 0.0;   // where rivers are, shade.comp knows
    ground_chance(ground, noise);
    ground_relief(ground, gradient, noise.shore);
    ground_climate(ground, zenith, gradient);
    ground_growth(ground);
    ground_steepness(ground);
    return ground;
}
