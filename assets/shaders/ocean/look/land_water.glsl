// Water of rivers and lakes: without the sea's waves, fresh and more or less muddy. Globals of the pixel at hand, which
// is set first.
#include "contract/land_water.glsl"

bool g_land_water;
float g_stirred, g_muddy;
vec3 g_loss_per_m, g_thrown_per_m;   // of the water, absorption and scattering; and what it throws back
#define WATER_LOSS g_loss_per_m
#define WATER_THROWN g_thrown_per_m

#include "ocean/look/pixel.glsl"

// Variance of slopes: of a calm lake, of gusts on it, and of water that shoots.
const float CALM_VARIANCE = 1.2e-3, GUST_VARIANCE = 1.6e-3, SHOOTING_VARIANCE = 0.04;

void land_water_set(float code) {
    vec2 found = land_water_decode(code);
    g_land_water = land_water_at(code);
    g_stirred = found.x;
    g_muddy = found.y;
    float silt = land_water_silt(g_muddy);
    g_thrown_per_m = ocean.scattering_per_m + (g_land_water ? FRESH_THROWN + silt * SILT_THROWN : vec3(0.0));
    g_loss_per_m = ocean.loss_per_m + (g_land_water ? FRESH_LOSS + silt * SILT_LOSS : vec3(0.0));
}

// What ocean/surface.comp has for the sea: variances along east and north, mixed, Jacobian. Gusts run over lakes in
// patches of some 50 m, as far as a pixel shows them.
vec4 land_water_rough(vec3 D, float footprint_m) {
    float seen = clamp(1.5 - footprint_m / 30.0, 0.0, 1.0);
    float gusts = seen > 0.0 ? mix(0.3, smoothstep(-0.2, 1.2, sea_noise(D, 10)), seen) : 0.3;
    float variance = CALM_VARIANCE + GUST_VARIANCE * gusts + SHOOTING_VARIANCE * g_stirred * g_stirred;
    return vec4(0.5 * variance, 0.5 * variance, 0.0, 1.0);
}

// How much of an octave of noise a pixel shows.
float land_water_seen(int octave, float footprint_m) {
    return clamp(2.0 - footprint_m * 4.0 / (NESTED_BASE_M * exp2(float(octave))), 0.0, 1.0);
}

// Share of white in falling water: shreds of all sizes, as far as a pixel shows them. asked: whether it falls here.
float falling_white(vec3 D, float footprint_m, bool asked) {
    float shreds = 0.0;
    int k = 7, end = asked ? 3 : 7;
    if (k > end) do {
        float shown = land_water_seen(k, footprint_m);
        shreds += shown > 0.0 ? shown * sea_noise(D, k) : 0.0;
    } while (--k > end);
    return clamp(0.8 + 0.2 * shreds, 0.25, 0.97);
}

// Share of white water: where it shoots, in patches as wide as rapids; where it falls, in shreds.
float land_water_foam(vec3 D, float footprint_m) {
    float share = land_water_white(g_stirred), seen = clamp(1.5 - footprint_m / 8.0, 0.0, 1.0);
    float patches = share > 0.0 && seen > 0.0 ? 0.8 * sea_noise(D, 8) + 0.5 * sea_noise(D, 6) : 0.0;
    float rapids = clamp(share * (1.0 + seen * 1.2 * patches), 0.0, 0.8);
    float falls = smoothstep(LAND_WATER_FALLS, 1.0, g_stirred);
    return mix(rapids, falling_white(D, footprint_m, falls > 0.0), falls);
}
