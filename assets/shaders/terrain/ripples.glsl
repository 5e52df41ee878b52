// What the wind makes of loose ground: ripples of sand a hand wide, ridges of snow (sastrugi) a metre wide. Waves whose
// phase is a sum of lattice coordinates, so that it goes on over cells and anchors, bent by an octave of noise.
#include "common/constants.glsl"
#include "generated/terrain_material_block.glsl"
#include "common/nested_noise.glsl"

// Gradient, metres per metre; w: height, -1..1. step: the wavelength is 0.036 m times 2 to this. bend: in wavelengths.
vec4 ripples(vec3 D, int octave, float bend, float footprint) {
    ivec3 cell, broad;
    vec3 fraction, place;
    float frequency, slower;
    nested_place(terrain_material_block.anchor.cell, terrain_material_block.anchor.fraction, D, octave, cell,
        fraction, frequency);
    nested_place(terrain_material_block.anchor.cell, terrain_material_block.anchor.fraction, D, octave + 3, broad,
        place, slower);
    vec4 noise = gradient_noise(broad, place) * (bend / NESTED_RMS);
    float seen = clamp(1.6 - 4.0 * footprint * frequency, 0.0, 1.0);
    // Between the second harmonic and the first: crests are sharper than troughs.
    float turn = TWO_PI * (fraction.x + fraction.y + fraction.z + noise.w);
    float strength = clamp(0.6 + noise.x / bend, 0.0, 1.0) * seen;
    vec2 wave = vec2(sin(turn), cos(turn));
    float slope = strength * (wave.y - 0.5 * (wave.y * wave.y - wave.x * wave.x));
    return vec4(slope * normalize(vec3(1.0) + noise.xyz * (slower / frequency)),
        strength * (wave.x - 0.5 * wave.x * wave.y));
}
