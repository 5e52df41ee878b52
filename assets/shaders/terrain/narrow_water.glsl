// Rivers too narrow for the picture's pixels, as a share of the ground in each: what terrain/land_water.comp found.
#include "generated/bindings.glsl"
#include "common/constants.glsl"
#include "terrain/land_water.glsl"
#include "contract/sky.glsl"
#include "contract/skylight.glsl"

layout(binding = LAND_WATER_UNIT) uniform usampler2D u_land_water;

struct NarrowWater {
    float coverage;         // share of the pixel
    float damp;             // 0..1: the bank is wet
    float stirred, muddy;   // as terrain/land_water.glsl has them
    float depth_m;          // of the nearest, in the mean
    float barred;           // 0..1: gravel or mud of its banks
};

// What deep rivers throw back of the light, clear and muddy ones, and white water.
const vec3 CLEAR_ALBEDO = vec3(0.018, 0.035, 0.03), MUDDY_ALBEDO = vec3(0.19, 0.15, 0.065), WHITE_ALBEDO = vec3(0.6);
// Loss of light in pure water and albedo of sand under the sea (components/ocean.py), and how much of what a bed throws
// back leaves the water: two passes of its surface, the second of which spreads it by the index squared.
const vec3 PURE_LOSS = vec3(0.35, 0.07, 0.03), SAND = vec3(0.34, 0.27, 0.17);
const float LEAVES = 0.55, WAY = 2.3;   // the way down and up by the depth
const float NARROW_VARIANCE = 0.006;   // of their slopes

NarrowWater narrow_water(ivec2 pixel) {
    uvec4 found = texelFetch(u_land_water, pixel, 0);
    vec4 parts = found.x == 0u ? unpackUnorm4x8(found.y) : vec4(0.0);
    float deep = found.x == 0u ? uintBitsToFloat(found.z) : 0.0;
    // A parabola.
    float barred = found.x == 0u ? unpackUnorm2x16(found.w).x : 0.0;
    return NarrowWater(parts.x, parts.y, parts.z, parts.w, 2.0 / 3.0 * deep, barred);
}

// Radiance of the water alone. sunlight: irradiance across the beam.
vec3 narrow_water_light(NarrowWater water, vec3 point, vec3 zenith, vec3 view, vec3 sunlight) {
    vec3 sun = frame.sun_direction, to_sky = reflect(-view, zenith);
    float mu = max(dot(view, zenith), 0.05), mu_sun = max(dot(sun, zenith), 0.0);
    float fresnel = 0.02 + 0.98 * pow(1.0 - mu, 5.0);
    float silt = land_water_silt(water.muddy);
    vec3 left = exp(-WAY * water.depth_m * (PURE_LOSS + FRESH_LOSS + silt * SILT_LOSS));
    vec3 albedo = mix(mix(CLEAR_ALBEDO, MUDDY_ALBEDO, silt), LEAVES * SAND * STONES, left);
    albedo = mix(albedo, WHITE_ALBEDO, land_water_white(water.stirred));
    vec3 below = albedo * (sunlight * mu_sun + skylight(point, zenith)) / PI;
    // The sun in facets whose slopes spread as a Gaussian (Cox and Munk 1954).
    float variance = NARROW_VARIANCE + 0.04 * water.stirred * water.stirred;
    vec3 facet = normalize(view + sun);
    float up = max(dot(facet, zenith), 0.05), slope2 = 1.0 / (up * up) - 1.0;
    float facing = max(dot(facet, view), 0.0);
    float mirrored = 0.02 + 0.98 * pow(1.0 - facing, 5.0);
    float glint = mu_sun > 0.0 ? mirrored * exp(-slope2 / variance) / (PI * variance * 4.0 * mu * up * up * up * up)
        : 0.0;
    to_sky = normalize(to_sky + zenith * max(0.02 - dot(to_sky, zenith), 0.0));
    return mix(below, sky(to_sky), fresnel) + sunlight * glint;
}
