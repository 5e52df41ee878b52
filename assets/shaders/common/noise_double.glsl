// Noise in double, of the same bits of the lattice as common/noise.glsl: for places that have no anchor nearby.
#include "common/noise.glsl"

NOISE_WEIGHTS(double, dvec3)

double noise_corner_double(vec3 g, double dx, double dy, double dz) {
    return double(g.x) * dx + double(g.y) * dy + double(g.z) * dz;
}

// The value in double, for octaves of kilometres that have to be right to a millimetre; the derivative is f32.
double gradient_noise_double(ivec3 cell, dvec3 f, out vec3 derivative) {
    NOISE_LATTICE_SIDES(cell, a, b)
    dvec3 e = f - 1.0LF;
    dvec3 u = noise_weights(f);
    vec3 g0 = vec3(lattice_hash(a.x, a.y, a.z)), g1 = vec3(lattice_hash(b.x, a.y, a.z));
    vec3 g2 = vec3(lattice_hash(a.x, b.y, a.z)), g3 = vec3(lattice_hash(b.x, b.y, a.z));
    vec3 g4 = vec3(lattice_hash(a.x, a.y, b.z)), g5 = vec3(lattice_hash(b.x, a.y, b.z));
    vec3 g6 = vec3(lattice_hash(a.x, b.y, b.z)), g7 = vec3(lattice_hash(b.x, b.y, b.z));
    double c0 = noise_corner_double(g0, f.x, f.y, f.z), c2 = noise_corner_double(g2, f.x, e.y, f.z);
    double c4 = noise_corner_double(g4, f.x, f.y, e.z), c6 = noise_corner_double(g6, f.x, e.y, e.z);
    double dx0 = noise_corner_double(g1, e.x, f.y, f.z) - c0, dx1 = noise_corner_double(g3, e.x, e.y, f.z) - c2;
    double dx2 = noise_corner_double(g5, e.x, f.y, e.z) - c4, dx3 = noise_corner_double(g7, e.x, e.y, e.z) - c6;
    NOISE_STEPS(double, u)
    vec3 v = vec3(u);
    derivative = mix(mix(mix(g0, g1, v.x), mix(g2, g3, v.x), v.y), mix(mix(g4, g5, v.x), mix(g6, g7, v.x), v.y), v.z);
    float sx = mix(mix(float(dx0), float(dx1), v.y), mix(float(dx2), float(dx3), v.y), v.z);
    float sy = mix(float(dy0), float(dy1), v.z);
    derivative = (derivative + noise_weight_slopes(vec3(f)) * vec3(sx, sy, float(dz))) * NOISE_GRADIENT_SCALE;
    return (y0 + u.z * dz) * double(NOISE_GRADIENT_SCALE);
}

dvec3 vector_noise(ivec3 cell, dvec3 f, out mat3 jacobian) {
    NOISE_VECTOR_STEPS(dvec3, cell, f)
    return (y0 + u.z * dz) * double(NOISE_GRADIENT_SCALE);
}
