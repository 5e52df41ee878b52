// Noise that repeats after a whole number of cells, for volumes that wrap. Hash and weights are those of
// common/noise.glsl.
#include "common/noise.glsl"

// cell: not below -64 times `cells`. GLSL leaves % of negative numbers undefined (some drivers take them as unsigned).
ivec3 tiled_hash(ivec3 cell, int cells, int seed) {
    uvec3 c = uvec3((cell + 64 * cells) % cells + 7919 * seed) * 1664525u + 1013904223u;
    return lattice_hash(c.x, c.y, c.z);
}

// Gradient noise, about -0.8..0.8; `place` in cells.
float tiled_gradient(vec3 place, int cells, int seed) {
    ivec3 cell = ivec3(floor(place));
    vec3 f = place - vec3(cell), u = noise_weights(f);
    float sum = 0.0;
    for (int i = 0; i < 8; ++i) {
        ivec3 corner = ivec3(i & 1, (i >> 1) & 1, i >> 2);
        vec3 side = vec3(corner);
        vec3 weight = mix(1.0 - u, u, side);
        vec3 gradient = vec3(tiled_hash(cell + corner, cells, seed)) * NOISE_GRADIENT_SCALE;
        sum += weight.x * weight.y * weight.z * dot(gradient, f - side);
    }
    return sum;
}

// Squared distances to the nearest two of feature points, one in each cell (Worley 1996).
vec2 tiled_nearest2(vec3 place, int cells, int seed) {
    ivec3 cell = ivec3(floor(place));
    vec3 f = place - vec3(cell);
    vec2 nearest2 = vec2(4.0);
    for (int i = 0; i < 27; ++i) {
        ivec3 away = ivec3(i % 3, (i / 3) % 3, i / 9) - 1;
        vec3 point = 0.5 + 0.5 * vec3(tiled_hash(cell + away, cells, seed)) * NOISE_GRADIENT_SCALE;
        vec3 to = vec3(away) + point - f;
        float distance2 = dot(to, to);
        nearest2 = vec2(min(nearest2.x, distance2), min(nearest2.y, max(nearest2.x, distance2)));
    }
    return nearest2;
}

// 1 at feature points, falling to 0 at a cell's width from them.
float tiled_worley(vec3 place, int cells, int seed) {
    return 1.0 - sqrt(min(tiled_nearest2(place, cells, seed).x, 1.0));
}

// 0 on the faces between cells.
float tiled_seams(vec3 place, int cells, int seed) {
    vec2 found = sqrt(tiled_nearest2(place, cells, seed));
    return found.y - found.x;
}
