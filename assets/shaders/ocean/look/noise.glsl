// Noise fixed to the planet around the sea's anchor.
#include "common/nested_noise.glsl"
#include "generated/ocean.glsl"

// Gradient noise of variance about 1 at a foot offset, with wavelength 0.0625 m * 2^k.
float sea_noise(vec3 D, int k) {
    ivec3 cell;
    vec3 fraction;
    float frequency;
    nested_place(ocean.anchor.cell, ocean.anchor.fraction, D, k, cell, fraction, frequency);
    return gradient_noise_value(cell, fraction) / NESTED_RMS;
}
