// Light in the water: refraction at the surface, what the column takes away and throws back, what comes up from it.
#include "common/constants.glsl"
#include "generated/ocean.glsl"

// Absorption and scattering, and what is thrown back, by the metre; whoever draws other water than the sea has its own.
#ifndef WATER_LOSS
#define WATER_LOSS ocean.loss_per_m
#define WATER_THROWN ocean.scattering_per_m
#endif

// Cosine to the vertical below the surface, of a direction with this one above.
float refracted_cosine(float cosine) {
    return sqrt(1.0 - (1.0 - cosine * cosine) * ocean.per_index_squared);
}

// Share of the light that is left after a path in water.
vec3 water_left(float path_m) {
    return exp(-WATER_LOSS * path_m);
}

// What bottomless water throws back, per irradiance that has come in from one direction.
vec3 deep_upwelling(float in_cosine, float out_cosine) {
    return WATER_THROWN / (WATER_LOSS * ((in_cosine + out_cosine) * PI));
}

// What shines up through the surface of water of a depth, per irradiance that has come in through it from one
// direction: single scattering on the way to the bed and back (`scattering`: light thrown back by the metre), and the
// bed itself. in_cosine, out_cosine: of the refracted paths.
vec3 water_upwelling(float depth_m, float in_cosine, float out_cosine, vec3 bed) {
    vec3 through = water_left(depth_m * (1.0 / in_cosine + 1.0 / out_cosine));
    vec3 thrown = WATER_THROWN / (WATER_LOSS * (in_cosine + out_cosine));
    return (thrown * (1.0 - through) + bed * through) / PI;
}
