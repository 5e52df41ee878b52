// Noise in fixed point, of the same bits of the lattice as common/noise.glsl: values to 2^-28 of their range, where
// float has 2^-22. For octaves of kilometres at places that have no anchor nearby. Derivatives are float.
#include "common/noise.glsl"
#include "common/fixed.glsl"

// Rounded, to 1 at most.
vec3 noise_single(uvec3 f) { return vec3(ivec3(f >> 1)) * (1.0 / 2147483648.0); }

// noise_weights of 2^-32, as ints with the bits of uints. The polynomial, 1 to 1.875, is a uint of 2^-31.
ivec3 noise_weights(uvec3 f) {
    ivec3 t = ivec3(f - 0x80000000u), tt = fixed_high(t, t), tttt = fixed_high(tt, tt);
    ivec3 v = fixed_share(ivec3(4026531840u - 2u * uvec3(tt)) - (tt >> 1) + 3 * tttt, t);
    return clamp(v, -1073741824, 1073741823) * 2 ^ ivec3(0x80000000u);
}

// From a to b, of which the difference has to be an int.
#define NOISE_FIXED_MIX(INT) INT noise_mix(int u, INT a, INT b) { return a + fixed_share(INT(u), b - a); }
NOISE_FIXED_MIX(int)
NOISE_FIXED_MIX(ivec3)

int noise_mix(int u, int v, int a, int b, int c, int d) { return noise_mix(v, noise_mix(u, a, b), noise_mix(u, c, d)); }

// A corner's hash in 2^-30.
ivec3 noise_corner(uint x, uint y, uint z) { return lattice_hash(x, y, z) << 7; }

#define NOISE_FIXED_CORNERS(cell) \
    NOISE_LATTICE_SIDES(cell, a, b) \
    ivec3 c0 = noise_corner(a.x, a.y, a.z), c1 = noise_corner(b.x, a.y, a.z); \
    ivec3 c2 = noise_corner(a.x, b.y, a.z), c3 = noise_corner(b.x, b.y, a.z); \
    ivec3 c4 = noise_corner(a.x, a.y, b.z), c5 = noise_corner(b.x, a.y, b.z); \
    ivec3 c6 = noise_corner(a.x, b.y, b.z), c7 = noise_corner(b.x, b.y, b.z);

// The value in 2^-30. Along each axis: of the gradients' components at its low and its high side, interpolated over the
// other two, (1 - u) f low - u (1 - f) high. Neither factor exceeds 0.3: doubled, they are still uints of 2^-32.
int gradient_noise(ivec3 cell, uvec3 f, out vec3 derivative) {
    derivative = gradient_noise(cell, noise_single(f)).xyz;
    NOISE_FIXED_CORNERS(cell)
    ivec3 u = noise_weights(f), low, high;
    low.x = noise_mix(u.y, u.z, c0.x, c2.x, c4.x, c6.x);
    high.x = noise_mix(u.y, u.z, c1.x, c3.x, c5.x, c7.x);
    low.y = noise_mix(u.x, u.z, c0.y, c1.y, c4.y, c5.y);
    high.y = noise_mix(u.x, u.z, c2.y, c3.y, c6.y, c7.y);
    low.z = noise_mix(u.x, u.y, c0.z, c1.z, c2.z, c3.z);
    high.z = noise_mix(u.x, u.y, c4.z, c5.z, c6.z, c7.z);
    uvec3 of_low, of_high, unused;
    umulExtended(f, ~uvec3(u), of_low, unused);
    umulExtended(~f, uvec3(u), of_high, unused);
    ivec3 twice = fixed_share(ivec3(of_low * 2u), low) - fixed_share(ivec3(of_high * 2u), high);
    return ((twice.x + twice.y) >> 1) + (twice.z >> 1);
}

// Vector noise in 2^-30.
ivec3 vector_noise(ivec3 cell, uvec3 f, out mat3 jacobian) {
    vector_noise(cell, noise_single(f), jacobian);
    NOISE_FIXED_CORNERS(cell)
    ivec3 u = noise_weights(f);
    return noise_mix(u.z, noise_mix(u.y, noise_mix(u.x, c0, c1), noise_mix(u.x, c2, c3)),
        noise_mix(u.y, noise_mix(u.x, c4, c5), noise_mix(u.x, c6, c7))) + 1;  // what floors take away, in the mean
}
