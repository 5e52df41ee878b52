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
        REAL x0 = c0 + before.x * dx0, x2 = c4 + before.x * dx2; \
        REAL dy0 = c2 + before.x * dx1 - x0, dy1 = c6 + before.x * dx3 - x2; \
        REAL dz = x2 + before.y * dy1 - (x0 + before.y * dy0); \
        return du.x * mix(mix(dx0, dx1, u.y), mix(dx2, dx3, u.y), u.z) + du.y * mix(dy0, dy1, u.z) + du.z * dz; \
    }

NOISE_CHANGE(float)
NOISE_CHANGE(vec3)

// Of gradient noise; there: gradient_noise at from + d. It is the mean gradient there times d, and what the weights'
// change makes of the corners' values before.
float gradient_noise_change(ivec3 cell, vec3 from, vec3 d, out vec4 there) {
    NOISE_LATTICE_SIDES(cell, a, b)
    vec3 f = from + d, e = f - 1.0;
    vec3 u = noise_weights(f), before = noise_weights(from), du = noise_weights_change(from, d);
    vec4 c0 = noise_corner(a.x, a.y, a.z, f.x, f.y, f.z), c1 = noise_corner(b.x, a.y, a.z, e.x, f.y, f.z);
    vec4 c2 = noise_corner(a.x, b.y, a.z, f.x, e.y, f.z), c3 = noise_corner(b.x, b.y, a.z, e.x, e.y, f.z);
    vec4 c4 = noise_corner(a.x, a.y, b.z, f.x, f.y, e.z), c5 = noise_corner(b.x, a.y, b.z, e.x, f.y, e.z);
    vec4 c6 = noise_corner(a.x, b.y, b.z, f.x, e.y, e.z), c7 = noise_corner(b.x, b.y, b.z, e.x, e.y, e.z);
    vec4 dx0 = c1 - c0, dx1 = c3 - c2, dx2 = c5 - c4, dx3 = c7 - c6;
    vec4 x0 = c0 + u.x * dx0, x1 = c2 + u.x * dx1, x2 = c4 + u.x * dx2, x3 = c6 + u.x * dx3;
    vec4 dy0 = x1 - x0, dy1 = x3 - x2;
    vec4 y0 = x0 + u.y * dy0;
    vec4 dz = x2 + u.y * dy1 - y0;
    there = y0 + u.z * dz;
    vec3 mean = there.xyz;
    float sx = mix(mix(dx0.w, dx1.w, u.y), mix(dx2.w, dx3.w, u.y), u.z);
    float sy = mix(dy0.w, dy1.w, u.z);
    there.xyz += noise_weight_slopes(f) * vec3(sx, sy, dz.w);
    there *= NOISE_GRADIENT_SCALE;

    float v0 = noise_corner_before(c0, d), v2 = noise_corner_before(c2, d);
    float v4 = noise_corner_before(c4, d), v6 = noise_corner_before(c6, d);
    float dv0 = noise_corner_before(c1, d) - v0, dv1 = noise_corner_before(c3, d) - v2;
    float dv2 = noise_corner_before(c5, d) - v4, dv3 = noise_corner_before(c7, d) - v6;
    return (dot(mean, d) + noise_change(v0, v2, v4, v6, dv0, dv1, dv2, dv3, before, u, du)) * NOISE_GRADIENT_SCALE;
}

// Of vector noise; there: vector_noise at from + d, with its jacobian.
vec3 vector_noise_change(ivec3 cell, vec3 from, vec3 d, out vec3 there, out mat3 jacobian) {
    NOISE_LATTICE_SIDES(cell, a, b)
    vec3 f = from + d;
    vec3 u = noise_weights(f), before = noise_weights(from), du = noise_weights_change(from, d);
    vec3 slopes = noise_weight_slopes(f) * NOISE_GRADIENT_SCALE;
    vec3 c0 = vec3(lattice_hash(a.x, a.y, a.z)), dx0 = vec3(lattice_hash(b.x, a.y, a.z)) - c0;
    vec3 c2 = vec3(lattice_hash(a.x, b.y, a.z)), dx1 = vec3(lattice_hash(b.x, b.y, a.z)) - c2;
    vec3 c4 = vec3(lattice_hash(a.x, a.y, b.z)), dx2 = vec3(lattice_hash(b.x, a.y, b.z)) - c4;
    vec3 c6 = vec3(lattice_hash(a.x, b.y, b.z)), dx3 = vec3(lattice_hash(b.x, b.y, b.z)) - c6;
    vec3 x0 = c0 + u.x * dx0, x2 = c4 + u.x * dx2;
    vec3 dy0 = c2 + u.x * dx1 - x0, dy1 = c6 + u.x * dx3 - x2;
    vec3 y0 = x0 + u.y * dy0;
    vec3 dz = x2 + u.y * dy1 - y0;
    jacobian[0] = slopes.x * mix(mix(dx0, dx1, u.y), mix(dx2, dx3, u.y), u.z);
    jacobian[1] = slopes.y * mix(dy0, dy1, u.z);
    jacobian[2] = slopes.z * dz;
    there = (y0 + u.z * dz) * NOISE_GRADIENT_SCALE;
    return noise_change(c0, c2, c4, c6, dx0, dx1, dx2, dx3, before, u, du) * NOISE_GRADIENT_SCALE;
}
