// 3D simplex noise; float64 twin and source in engine/surface/simplex.py. A place is a cell of the skewed lattice and a
// skewed fraction of it, so that planet coordinates never appear in f32.
#include "common/noise.glsl"

const float SIMPLEX_SCALE = 60.0;

float simplex_corner(uvec3 words, vec3 d) {
    float t = max(0.5 - dot(d, d), 0.0);
    t *= t;
    return t * t * dot(vec3(lattice_hash(words.x, words.y, words.z)), d);
}

// Noise in (-1, 1) at skewed fraction f in [0, 1]^3 of a cell.
float simplex_noise(ivec3 cell, vec3 f) {
    uvec3 words = uvec3(cell) * 1664525u + 1013904223u;
    bool xy = f.x >= f.y, xz = f.x >= f.z, yz = f.y >= f.z;
    uvec3 first = uvec3(xy && xz, !xy && yz, 0u);
    first.z = 1u - first.x - first.y;
    uvec3 last = uvec3(!xy && !xz, xy && !yz, 0u);
    last.z = 1u - last.x - last.y;
    uvec3 second = 1u - last;
    vec3 d = f - (f.x + f.y + f.z) * (1.0 / 6.0);
    float n = simplex_corner(words, d)
        + simplex_corner(words + first * 1664525u, d - vec3(first) + 1.0 / 6.0)
        + simplex_corner(words + second * 1664525u, d - vec3(second) + 1.0 / 3.0)
        + simplex_corner(words + 1664525u, d - 0.5);
    return n * (SIMPLEX_SCALE * NOISE_GRADIENT_SCALE);
}
