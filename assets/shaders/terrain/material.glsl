// What the ground is made of: rock, scree, soil, grass, forest, tundra, sand and snow, by height, slope, latitude and
// moisture, broken up by noise whose wavelengths follow the pixel's footprint. What is smaller than a pixel counts as a
// share of it: slopes and heights that the footprint hides enter as a variance, so that the colour of a place stays the
// same from 2 m to 36 000 km.
#include "generated/planet.glsl"
#include "generated/terrain_material_block.glsl"
#include "terrain/ground_detail.glsl"

struct Material {
    vec3 albedo;
    float grain;      // height of the bumps below the terrain's shortest layer
    float deviation;  // rms slope of the relief that the footprint hides
    float rock;       // share of bare rock
    float stony;      // of cells of clutter that hold a stone, off the beach
    vec4 leafy;       // and a plant: a tuft, a tussock, a shrub, a tree
    vec3 plant;       // albedo of plants
    float sandy;      // share of loose sand, in ripples
    float snowy;      // and of snow, in ridges
};

// Variance of the slopes of relief shorter than twice a length: a fit to the layers' table.
float hidden_slope_variance(float roughness, float footprint) {
    vec4 relief = terrain_material_block.relief;
    float t = clamp(log2(footprint * relief.x) * relief.z, 0.0, 1.0);
    return roughness * roughness * relief.y * t * t;
}

// 0 below a, 1 above b, straight between them: cheaper than smoothstep, and noise on x hides the corners.
float ramp(float a, float b, float x) {
    return clamp((x - a) * (1.0 / (b - a)), 0.0, 1.0);
}

float bell(float x, float center, float inverse_width) {
    float t = (x - center) * inverse_width;
    t = max(1.0 - t * t, 0.0);
    return t * t;
}

// Layers of rock: four widths of strata that wave with the noise, each gone where the pixel spans one.
float strata(float height, float wave, float rise_of_pixel) {
    vec4 frequency = terrain_material_block.relief.w * vec4(1.0, 6.0, 38.0, 230.0);
    vec4 s = abs(2.0 * fract(height * frequency + wave * vec4(0.15, 0.3, 0.5, 0.7)) - 1.0);
    s = s * s * (3.0 - 2.0 * s) - 0.5;
    vec4 seen = clamp(1.5 - 3.0 * rise_of_pixel * frequency, 0.0, 1.0);
    return dot(s * seen, vec4(0.6, 0.4, 0.35, 0.3));
}

// gradient: of the visible relief, metres per metre; footprint: what a pixel covers, in metres.
Material terrain_material(
    GroundDetail noise, vec3 D, vec3 zenith, float height, vec3 gradient, float roughness, float moisture,
        float footprint
) {
    // From far away climate shows more than chance.
    float variation = terrain_material_block.look.x * mix(1.0, 0.4, ramp(8.0, 15.0, log2(footprint)));
    float grain = noise.fine * variation, patches = noise.broad * variation, mixed = 0.7 * patches + 0.5 * grain;

    float variance = hidden_slope_variance(roughness, footprint);
    float deviation = sqrt(variance);
    float slope = sqrt(dot(gradient, gradient) + variance);
    float above_sea = height - (planet.sea.y > 0.5 ? planet.sea.x : -1.0e9);

    // Warmth: 0 at the snow line, 1 at the equator's sea. It falls with height and towards the poles.
    vec4 climate = terrain_material_block.climate;
    float sine2 = zenith.z * zenith.z, sine = sqrt(sine2);
    float line = climate.x + climate.y * sine2 * (0.4 + 0.6 * sine);
    float warmth = (line - height) * climate.w + 0.025 * mixed;

    // Humidity: wet at the equator and in the westerlies, dry under the descending air at 25 degrees (the Hadley cell).
    float climatic = climate.z + 0.9 * moisture + 0.30 * bell(sine, 0.0, 3.6) - 0.34 * bell(sine, 0.42, 3.2)
        + 0.16 * bell(sine, 0.85, 2.2);
    float humidity = climatic + 0.10 * mixed;
    float plants = terrain_material_block.dry.w;
    float green = ramp(0.32, 0.50, humidity) * plants;
    float wooded = ramp(0.52, 0.70, humidity + 0.04 * grain) * ramp(0.15, 0.28, warmth);

    // Level ground. Peaks of the fine noise are stones, its hollows shrubs or tufts; far away they are a mean tint.
    float spots = ramp(120.0, 6.0, footprint) * variation;
    float stones = ramp(1.0, 1.6, noise.fine + 0.4 * noise.broad) * spots;
    float tufts = ramp(0.6, 1.5, 0.5 * mixed - noise.fine) * spots;
    vec3 dry = terrain_material_block.dry.rgb;
    float sanded = ramp(-0.5, 1.3, mixed - 2.5 * humidity + 0.62);
    vec3 soil = mix(dry, terrain_material_block.sand.rgb, 0.8 * sanded);
    soil = mix(soil, terrain_material_block.sand.rgb, 0.9 * (1.0 - plants) * ramp(0.50, 0.64, moisture + 0.06 * mixed));
    soil = mix(soil, terrain_material_block.gravel.rgb, 0.65 * ramp(0.7, 1.9, 1.2 * patches - mixed + 2.0 * roughness));
    soil = mix(soil, dry * vec3(0.40, 0.42, 0.46), ramp(0.15, 0.5, humidity) * plants);
    soil = mix(soil, terrain_material_block.rock.rgb * 1.1, stones * 0.6);
    soil = mix(soil, terrain_material_block.hay.rgb * 0.5, tufts * 0.7 * plants * ramp(0.1, 0.33, humidity));
    float withered = clamp(ramp(0.60, 0.37, humidity) * 0.8 + 0.32 * mixed + 0.1 * grain, 0.0, 1.0);
    vec3 plant = mix(terrain_material_block.grass.rgb, terrain_material_block.hay.rgb, withered);
    plant = mix(plant, terrain_material_block.forest.rgb, wooded);
    plant = mix(terrain_material_block.tundra.rgb * (1.0 + 0.25 * mixed), plant,
        ramp(0.07, 0.25, warmth + 0.015 * grain));
    plant *= 1.0 + 0.24 * grain - 0.3 * tufts;
    float cover = green * ramp(-1.6, -0.3, grain + 2.0 * green - 1.0);
    vec3 albedo = mix(soil, plant, cover);

    // Steep ground: scree first, then rock in layers. Rough ground, as of mountain ranges, turns to rock earlier.
    // Roots hold soil on slopes that would be bare in a dry or cold place.
    float rooted = green * ramp(0.05, 0.3, warmth);
    float bare = terrain_material_block.rock.w * clamp(1.25 - roughness, 0.5, 1.0) * (1.0 + 0.9 * rooted);
    // Bumps of a few metres alone are no cliffs.
    float bumpy = sqrt(hidden_slope_variance(roughness, max(footprint, 10.0)));
    float steep = (slope - bare) / (0.25 * bare + bumpy) + 0.45 * grain;
    float rocky = smoothstep(-1.0, 1.0, steep);
    float layered = strata(height, mixed, footprint * (0.1 + slope)) * terrain_material_block.strata.w;
    vec3 rock = mix(terrain_material_block.rock.rgb, terrain_material_block.strata.rgb,
        clamp(0.35 + layered + 0.3 * patches, 0.0, 1.0));
    rock *= 1.0 + 0.2 * grain - 0.25 * tufts;
    albedo = mix(albedo, 0.75 * rock + 0.25 * dry, (0.55 - 0.4 * rooted) * ramp(-1.7, -0.4, steep));
    albedo = mix(albedo, rock, rocky);

    // Sand along the sea; as a share of the pixel where the beach is narrower than that.
    float beach_m = terrain_material_block.sand.w * (1.0 + 0.4 * clamp(mixed, -2.0, 2.0));
    float rise = max(slope, 0.02) * footprint;
    float beach = beach_m / (beach_m + 0.5 * rise + 1e-3)
        * clamp(2.5 - 2.5 * (above_sea - 0.5 * rise) / (beach_m + rise + 1e-3), 0.0, 1.0);
    beach *= (1.0 - rocky) * ramp(2500.0, 250.0, footprint);
    albedo = mix(albedo, terrain_material_block.sand.rgb * (1.0 + 0.07 * grain + 0.07 * stones), beach);

    // Snow: above its line, as wide as the hidden relief spreads it; thin on steep faces.
    float hidden = min(0.25 * deviation * footprint * climate.w, 0.12), spread = 0.012 + 0.6 * hidden;
    float snowy = smoothstep(spread, -spread, warmth - (0.012 + 0.5 * hidden) * grain - 0.012 * mixed);
    float sheds = (slope - terrain_material_block.snow.w) / (0.25 * terrain_material_block.snow.w + deviation)
        + 0.7 * grain + 0.4 * mixed;
    snowy *= 1.0 - 0.9 * smoothstep(-1.0, 1.0, sheds);
    albedo *= 1.0 + 0.12 * patches + 0.08 * grain;
    albedo = mix(albedo, terrain_material_block.snow.rgb * (1.0 + 0.03 * patches + 0.025 * grain), snowy);

    // What stands on it: plants, fewer where it is dry, and stones. All this hangs on the place alone, not on the
    // pixel's footprint, so nothing comes or goes when the camera moves. Beaches count where a thing has its foot
    // (terrain/clutter.glsl).
    float open_ground = (1.0 - rocky) * (1.0 - snowy);
    float growing = ramp(0.25, 0.55, climatic) * plants * open_ground;
    float stony = (0.04 + 0.3 * (1.0 - growing) + 0.15 * roughness) * (1.0 - snowy);
    float woods = ramp(0.50, 0.72, climatic) * ramp(0.15, 0.28, (line - height) * climate.w);
    vec4 leafy = growing * vec4(0.95, 0.32, 0.10 + 0.45 * woods, woods);

    Material material;
    material.albedo = clamp(albedo, 0.0, 1.0);
    material.grain = mix(mix(1.0, 0.4, beach), 1.8, rocky) * (1.0 - 0.5 * snowy) * terrain_material_block.look.z;
    material.deviation = deviation;
    material.rock = rocky;
    material.stony = stony;
    material.leafy = leafy;
    material.plant = plant;
    material.sandy = max(beach, sanded * (1.0 - cover)) * (1.0 - rocky) * (1.0 - snowy);
    material.snowy = snowy;
    return material;
}
