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
};

// Variance of the slopes of relief shorter than a length: a fit to the layers, most of whose steepness is in the few
// longest.
float hidden_slope_variance(float roughness, float length_m) {
    vec4 relief = terrain_material_block.relief;
    float t = clamp(log2(max(length_m, 1e-6) / relief.x) * relief.z, 0.0, 1.0);
    return roughness * roughness * relief.y * t * t * t * t;
}

float bell(float x, float center, float inverse_width) {
    float t = clamp((x - center) * inverse_width, -1.0, 1.0);
    t = 1.0 - t * t;
    return t * t;
}

// Layers of rock: two widths of strata that wave with the noise, each gone where the pixel spans one.
float strata(float height, float wave, float rise_of_pixel) {
    vec2 period = terrain_material_block.relief.w * vec2(1.0, 0.17);
    vec2 t = fract(height / period + wave * vec2(0.15, 0.3));
    vec2 s = abs(2.0 * t - 1.0);
    s = s * s * (3.0 - 2.0 * s) - 0.5;
    vec2 seen = clamp(1.5 - 3.0 * rise_of_pixel / period, 0.0, 1.0);
    return dot(s * seen, vec2(0.6, 0.4));
}


float roughness_of_grain(float rocky, float snowy, float beach) {
    return mix(mix(1.0, 0.4, beach), 1.8, rocky) * (1.0 - 0.5 * snowy);
}

Material terrain_material(
    GroundDetail noise, vec3 zenith, float height, vec3 gradient, float roughness, float moisture, float footprint
) {
    float variation = terrain_material_block.look.x;
    float mixed = (0.7 * noise.broad + 0.5 * noise.fine) * variation, grain = noise.fine * variation;

    float variance = hidden_slope_variance(roughness, 2.0 * footprint);
    float deviation = sqrt(variance);
    float slope = sqrt(dot(gradient, gradient) + variance);
    float sea = planet.sea.y > 0.5 ? planet.sea.x : -1.0e9;
    float above_sea = height - sea;

    // Warmth: 0 at the snow line, 1 at the equator's sea. It falls with height and towards the poles.
    float sine2 = zenith.z * zenith.z, sine = sqrt(sine2);
    float line = mix(terrain_material_block.climate.x, terrain_material_block.climate.y, sine2 * (0.4 + 0.6 * sine));
    float reach = max(terrain_material_block.climate.x - terrain_material_block.climate.y, 500.0);
    float hidden_height = deviation * footprint * 0.25;
    float warmth = (line - height) / reach + 0.025 * mixed;

    // Humidity: wet at the equator and in the westerlies, dry under the descending air at 25 degrees (the Hadley cell).
    float humidity = terrain_material_block.climate.z + 0.9 * (moisture - 0.5) + 0.30 * bell(sine, 0.0, 3.6) - 0.34 * bell(sine, 0.42, 3.2)
        + 0.16 * bell(sine, 0.85, 2.2) + 0.10 * mixed;
    float plants = terrain_material_block.dry.w;
    float green = smoothstep(0.30, 0.52, humidity) * plants;
    float wooded = smoothstep(0.50, 0.72, humidity + 0.04 * grain) * smoothstep(0.14, 0.3, warmth);

    // Level ground. Peaks of the fine noise are stones, its hollows shrubs or tufts; far away they are a mean tint.
    float spots = smoothstep(120.0, 6.0, footprint) * variation;
    float stones = smoothstep(0.9, 1.7, noise.fine + 0.4 * noise.broad) * spots;
    float tufts = smoothstep(0.5, 1.6, -noise.fine + 0.5 * mixed) * spots;
    vec3 soil = mix(terrain_material_block.dry.rgb, terrain_material_block.sand.rgb, smoothstep(-0.6, 1.4, mixed - 2.5 * (humidity - 0.25)) * 0.8);
    vec3 gravel = mix(terrain_material_block.strata.rgb, terrain_material_block.rock.rgb, 0.55);
    soil = mix(soil, gravel, smoothstep(0.1, 1.5, 1.2 * noise.broad * variation - mixed + 2.0 * roughness - 0.5) * 0.65);
    soil = mix(soil, terrain_material_block.dry.rgb * 0.6, smoothstep(0.2, 0.9, humidity) * plants);
    soil = mix(soil, terrain_material_block.rock.rgb * 1.1, stones * 0.6);
    vec3 hay = 0.45 * terrain_material_block.grass.rgb + 0.35 * terrain_material_block.dry.rgb;
    vec3 grass = mix(terrain_material_block.grass.rgb, hay, clamp(smoothstep(0.62, 0.35, humidity) * 0.8 + 0.22 * mixed + 0.1 * grain, 0.0, 1.0));
    vec3 plant = mix(grass, terrain_material_block.forest.rgb, wooded);
    plant = mix(terrain_material_block.tundra.rgb * (1.0 + 0.25 * mixed), plant, smoothstep(0.06, 0.26, warmth + 0.015 * grain));
    plant *= 1.0 + 0.16 * grain - 0.3 * tufts;
    float cover = green * smoothstep(-1.7, -0.2, grain + 2.0 * (green - 0.5));
    soil = mix(soil, hay * 0.5, tufts * 0.7 * plants * smoothstep(0.08, 0.35, humidity));
    vec3 level = mix(soil, plant, cover);

    // Steep ground: scree first, then rock in layers.
    float steep = (slope - terrain_material_block.rock.w) / (0.25 * terrain_material_block.rock.w + deviation) + 0.45 * grain;
    float rocky = smoothstep(-1.0, 1.0, steep);
    float scree = smoothstep(-2.6, -0.6, steep);
    float layered = strata(height, mixed, footprint * (0.3 + slope)) * terrain_material_block.strata.w;
    vec3 rock = mix(terrain_material_block.rock.rgb, terrain_material_block.strata.rgb, clamp(0.35 + layered + 0.3 * noise.broad * variation, 0.0, 1.0));
    rock *= 1.0 + 0.2 * grain - 0.25 * tufts;
    vec3 albedo = mix(level, mix(rock, terrain_material_block.dry.rgb, 0.25), scree * 0.6);
    albedo = mix(albedo, rock, rocky);

    // Sand along the sea, wet at its edge; as a share of the pixel where the beach is narrower than that.
    float beach_m = terrain_material_block.sand.w * (1.0 + 0.4 * mixed);
    float rise = max(length(gradient), 0.02) * footprint;
    float beach = clamp(beach_m / (beach_m + 0.5 * rise), 0.0, 1.0) * (1.0 - smoothstep(0.6, 1.0, (above_sea - 0.5 * rise) / max(beach_m + rise, 1e-3)));
    float wet = 1.0 - smoothstep(0.1, 0.5 + 0.15 * mixed, above_sea / max(0.15 * terrain_material_block.sand.w, 1e-3));
    albedo = mix(albedo, terrain_material_block.sand.rgb * mix(1.0 + 0.1 * grain, 0.5, wet), beach * (1.0 - rocky));

    // Snow: above its line, as wide as the hidden relief spreads it; thin on steep faces.
    float spread = (80.0 + hidden_height) / reach;
    float snowy = smoothstep(spread, -spread, warmth - 0.012 * grain - 0.012 * mixed);
    float holds = 1.0 - smoothstep(-1.0, 1.0, (slope - terrain_material_block.snow.w) / (0.25 * terrain_material_block.snow.w + deviation) + 0.7 * grain + 0.4 * mixed);
    snowy *= mix(0.1, 1.0, holds);
    vec3 snow = terrain_material_block.snow.rgb * (1.0 + (0.03 * noise.broad + 0.025 * noise.fine) * variation);
    albedo *= 1.0 + (0.12 * noise.broad + 0.08 * noise.fine) * variation;
    albedo = mix(albedo, snow, snowy);

    Material material;
    material.albedo = clamp(albedo, 0.0, 1.0);
    material.grain = roughness_of_grain(rocky, snowy, beach) * terrain_material_block.look.z;
    material.deviation = deviation;
    return material;
}
