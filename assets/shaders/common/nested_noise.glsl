// Gradient noise at any wavelength of BASE * 2^k from one anchored place: the lattices nest, so the anchor's cell at
// the shortest wavelength (integers) and its fraction, both from float64, give its place in all others by shifts. What
// the GPU adds is the offset D from the anchor's foot, so nothing moves when the anchor does.
#include "common/noise.glsl"

const float NESTED_BASE_M = 0.0625;
const float NESTED_RMS = 0.27;  // of gradient_noise: divides it to a variance of about one

// k in 0..29. Each lattice is shifted by its own share of a cell: noise is zero at lattice points, which would else
// coincide.
void nested_place(ivec3 anchor_cell, vec3 anchor_fraction, vec3 D, int k, out ivec3 cell, out vec3 fraction,
    out float frequency) {
    float per_cell = exp2(-float(k));
    frequency = per_cell / NESTED_BASE_M;
    vec3 place = (vec3(anchor_cell & ((1 << k) - 1)) + anchor_fraction) * per_cell;
    vec3 t = D * frequency;
    vec3 whole = floor(t);
    fraction = (t - whole) + place + fract(vec3(0.618034, 0.754878, 0.569840) * float(k + 1));
    vec3 carry = floor(fraction);
    fraction -= carry;
    cell = (anchor_cell >> k) + ivec3(whole) + ivec3(carry) + 7919 * k;
}

// xyz: gradient by metres, w: value, both times 1 / NESTED_RMS.
vec4 nested_noise(ivec3 anchor_cell, vec3 anchor_fraction, vec3 D, int k) {
    ivec3 cell;
    vec3 fraction;
    float frequency;
    nested_place(anchor_cell, anchor_fraction, D, k, cell, fraction, frequency);
    vec4 n = gradient_noise(cell, fraction) / NESTED_RMS;
    n.xyz *= frequency;
    return n;
}
