// Gradient noise on an integer lattice; float64 twins in engine/surface/noise.py.
// Perlin 2002 (quintic weights) with gradients from the PCG3D hash (Jarzynski and Olano 2020): the same bits on every
// GPU and in numpy. A point is an integer cell and a fraction of it: planet coordinates never appear in f32.
// The eight corners are written out once, in a macro: they share the hash's first multiply-add (3.0 ns an octave with
// derivatives on two cores of llvmpipe, against 3.8 for a loop over corners). Loop over octaves, not over corners.

const float NOISE_GRADIENT_SCALE = 1.0 / 8388608.0;  // 2^-23: 24-bit signed hash bits to [-1, 1), exact in f32

// PCG3D without its first multiply-add (the caller's), as a vector with 24-bit integer components.
ivec3 lattice_hash(uint x, uint y, uint z) {
    x += y * z;
    y += z * x;
    z += x * y;
    x ^= x >> 16u;
    y ^= y >> 16u;
    z ^= z >> 16u;
    x += y * z;
    y += z * x;
    z += x * y;
    return ivec3(x, y, z) >> 8;
}

#define NOISE_LATTICE_SIDES(cell, a, b) \
    uvec3 a = uvec3(cell) * 1664525u + 1013904223u; \
    uvec3 b = a + 1664525u;

// The place d from an anchor's, which is `anchor_fraction` of `anchor_cell`; the product has to be exact.
void lattice_place(
    ivec3 anchor_cell, vec3 anchor_fraction, float frequency, vec3 d, out ivec3 cell, out vec3 fraction
) {
    vec3 t = d * frequency;
    vec3 whole = floor(t);
    fraction = (t - whole) + anchor_fraction;
    vec3 carry = floor(fraction);
    fraction -= carry;
    cell = anchor_cell + ivec3(whole) + ivec3(carry);
}

// 6 f^5 - 15 f^4 + 10 f^3 around the middle, where it is odd: the text-book form loses four bits near f = 1.
#define NOISE_WEIGHTS(REAL, REAL3) \
    REAL3 noise_weights(REAL3 f) { \
        REAL3 t = f - REAL(0.5); \
        REAL3 tt = t * t; \
        return REAL(0.5) + t * (REAL(1.875) + tt * (REAL(6.0) * tt - REAL(5.0))); \
    }

NOISE_WEIGHTS(float, vec3)

vec3 noise_weight_slopes(vec3 f) {
    vec3 t = f * (f - 1.0);
    return 30.0 * t * t;
}

// A corner for gradient noise: xyz gradient, w its value at offset d from the corner.
vec4 noise_corner(uint x, uint y, uint z, float dx, float dy, float dz) {
    vec3 g = vec3(lattice_hash(x, y, z));
    return vec4(g, g.x * dx + g.y * dy + g.z * dz);
}

// Of corners' values (c0, c2, c4, c6 at x = 0, the steps from there along x are dx0..dx3) by weights u: the steps along
// y and z, and y0 at z = 0.
#define NOISE_STEPS(KIND, u) \
    KIND x0 = c0 + u.x * dx0, x2 = c4 + u.x * dx2; \
    KIND dy0 = c2 + u.x * dx1 - x0, dy1 = c6 + u.x * dx3 - x2; \
    KIND y0 = x0 + u.y * dy0; \
    KIND dz = x2 + u.y * dy1 - y0;

// Gradient noise, unscaled: the corners c0..c7, their mean gradient, and `sum`.
#define NOISE_GRADIENT_SUM(cell, f) \
    NOISE_LATTICE_SIDES(cell, a, b) \
    vec3 e = f - 1.0, u = noise_weights(f); \
    vec4 c0 = noise_corner(a.x, a.y, a.z, f.x, f.y, f.z), c1 = noise_corner(b.x, a.y, a.z, e.x, f.y, f.z); \
    vec4 c2 = noise_corner(a.x, b.y, a.z, f.x, e.y, f.z), c3 = noise_corner(b.x, b.y, a.z, e.x, e.y, f.z); \
    vec4 c4 = noise_corner(a.x, a.y, b.z, f.x, f.y, e.z), c5 = noise_corner(b.x, a.y, b.z, e.x, f.y, e.z); \
    vec4 c6 = noise_corner(a.x, b.y, b.z, f.x, e.y, e.z), c7 = noise_corner(b.x, b.y, b.z, e.x, e.y, e.z); \
    vec4 dx0 = c1 - c0, dx1 = c3 - c2, dx2 = c5 - c4, dx3 = c7 - c6; \
    NOISE_STEPS(vec4, u) \
    vec4 sum = y0 + u.z * dz; \
    vec3 mean = sum.xyz; \
    float sx = mix(mix(dx0.w, dx1.w, u.y), mix(dx2.w, dx3.w, u.y), u.z), sy = mix(dy0.w, dy1.w, u.z); \
    sum.xyz += noise_weight_slopes(f) * vec3(sx, sy, dz.w);

// Gradient noise: xyz = derivative by the lattice coordinate, w = value, at `f` in [0, 1]^3 of `cell`.
vec4 gradient_noise(ivec3 cell, vec3 f) {
    NOISE_GRADIENT_SUM(cell, f)
    return sum * NOISE_GRADIENT_SCALE;
}

// The value alone.
float gradient_noise_value(ivec3 cell, vec3 f) {
    NOISE_LATTICE_SIDES(cell, a, b)
    vec3 e = f - 1.0;
    vec3 u = noise_weights(f);
    float x0 = mix(noise_corner(a.x, a.y, a.z, f.x, f.y, f.z).w, noise_corner(b.x, a.y, a.z, e.x, f.y, f.z).w, u.x);
    float x1 = mix(noise_corner(a.x, b.y, a.z, f.x, e.y, f.z).w, noise_corner(b.x, b.y, a.z, e.x, e.y, f.z).w, u.x);
    float x2 = mix(noise_corner(a.x, a.y, b.z, f.x, f.y, e.z).w, noise_corner(b.x, a.y, b.z, e.x, f.y, e.z).w, u.x);
    float x3 = mix(noise_corner(a.x, b.y, b.z, f.x, e.y, e.z).w, noise_corner(b.x, b.y, b.z, e.x, e.y, e.z).w, u.x);
    return mix(mix(x0, x1, u.y), mix(x2, x3, u.y), u.z) * NOISE_GRADIENT_SCALE;
}

// Vector noise: the corners, and `jacobian`; REAL3 is the type of values.
#define NOISE_VECTOR_STEPS(REAL3, cell, f) \
    NOISE_LATTICE_SIDES(cell, a, b) \
    REAL3 u = noise_weights(f); \
    REAL3 c0 = REAL3(lattice_hash(a.x, a.y, a.z)), dx0 = REAL3(lattice_hash(b.x, a.y, a.z)) - c0; \
    REAL3 c2 = REAL3(lattice_hash(a.x, b.y, a.z)), dx1 = REAL3(lattice_hash(b.x, b.y, a.z)) - c2; \
    REAL3 c4 = REAL3(lattice_hash(a.x, a.y, b.z)), dx2 = REAL3(lattice_hash(b.x, a.y, b.z)) - c4; \
    REAL3 c6 = REAL3(lattice_hash(a.x, b.y, b.z)), dx3 = REAL3(lattice_hash(b.x, b.y, b.z)) - c6; \
    NOISE_STEPS(REAL3, u) \
    vec3 v = vec3(u), slopes = noise_weight_slopes(vec3(f)) * NOISE_GRADIENT_SCALE; \
    jacobian[0] = slopes.x * mix(mix(vec3(dx0), vec3(dx1), v.y), mix(vec3(dx2), vec3(dx3), v.y), v.z); \
    jacobian[1] = slopes.y * mix(vec3(dy0), vec3(dy1), v.z); \
    jacobian[2] = slopes.z * vec3(dz);

// Vector value noise (the hash itself, interpolated), each component in (-1, 1), for warps; column j of `jacobian`
// is the derivative by coordinate j.
vec3 vector_noise(ivec3 cell, vec3 f, out mat3 jacobian) {
    NOISE_VECTOR_STEPS(vec3, cell, f)
    return (y0 + u.z * dz) * NOISE_GRADIENT_SCALE;
}
