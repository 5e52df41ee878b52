// How much noise changes from one place to another in the same cell of its lattice: errors are relative to the way
// between them, where a difference of two noises has those of the noises themselves. From `from` in [0, 1]^3 of `cell`
// by `d`, in cells.
#include "common/noise.glsl"

// noise_weights at from + d less those at from: a^n - b^n = (a - b) (a^(n-1) + ... + b^(n-1)) in each power.
vec3 noise_weights_change(vec3 from, vec3 d) {
    vec3 b = from - 0.5, a = b + d;
    vec3 squares = a * a + b * b, ab = a * b, both = squares + ab;
    return d * (1.875 - 5.0 * both + 6.0 * (squares * both - ab * ab));
}

// A corner's value at the place that is d before the one of its own.
float noise_corner_before(vec4 corner, vec3 d) {
    return corner.w - (corner.x * d.x + corner.y * d.y + corner.z * d.z);
}

// Of corners' values (those at x = 0 and the steps from there along x), interpolated: the change from weights `before`
// to u = before + du, axis by axis.
#define NOISE_CHANGE(REAL) \
    REAL noise_change( \
        REAL c0, REAL c2, REAL c4, REAL c6, REAL dx0, REAL dx1, REAL dx2, REAL dx3, vec3 before, vec3 u, vec3 du \
    ) { \
        NOISE_STEPS(REAL, before) \
        return du.x * mix(mix(dx0, dx1, u.y), mix(dx2, dx3, u.y), u.z) + du.y * mix(dy0, dy1, u.z) + du.z * dz; \
    }

NOISE_CHANGE(float)
NOISE_CHANGE(vec3)

// Of gradient noise; there: gradient_noise at from + d. It is the mean gradient there times d, and what the weights'
// change makes of the corners' values before.
float gradient_noise_change(ivec3 cell, vec3 from, vec3 d, out vec4 there) {
    vec3 f = from + d;
    NOISE_GRADIENT_SUM(cell, f)
    there = sum * NOISE_GRADIENT_SCALE;

    float v0 = noise_corner_before(c0, d), v2 = noise_corner_before(c2, d);
    float v4 = noise_corner_before(c4, d), v6 = noise_corner_before(c6, d);
    float dv0 = noise_corner_before(c1, d) - v0, dv1 = noise_corner_before(c3, d) - v2;
    float dv2 = noise_corner_before(c5, d) - v4, dv3 = noise_corner_before(c7, d) - v6;
    vec3 before = noise_weights(from), du = noise_weights_change(from, d);
    return (dot(mean, d) + noise_change(v0, v2, v4, v6, dv0, dv1, dv2, dv3, before, u, du)) * NOISE_GRADIENT_SCALE;
}

// Of vector noise; there: vector_noise at from + d, with its jacobian.
vec3 vector_noise_change(ivec3 cell, vec3 from, vec3 d, out vec3 there, out mat3 jacobian) {
    vec3 f = from + d;
    NOISE_VECTOR_STEPS(vec3, cell, f)
    there = (y0 + u.z * dz) * NOISE_GRADIENT_SCALE;
    vec3 before = noise_weights(from), du = noise_weights_change(from, d);
    return noise_change(c0, c2, c4, c6, dx0, dx1, dx2, dx3, before, u, du) * NOISE_GRADIENT_SCALE;
}
