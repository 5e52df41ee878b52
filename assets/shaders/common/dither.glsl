// Noise against banding in 8 bits: integers only, the same on every machine and in every frame.

uvec3 dither_hash(uvec3 v) {  // PCG3D (Jarzynski and Olano 2020)
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.z; v.y += v.z * v.x; v.z += v.x * v.y;
    v ^= v >> 16u;
    v.x += v.y * v.z; v.y += v.z * v.x; v.z += v.x * v.y;
    return v;
}

// Triangular noise in -0.5..0.5, independent for red, green and blue. It is the difference of two uniform numbers, each
// shared with a neighbour of opposite sign, so that it has little of the low frequencies that the eye sees best.
vec3 dither_noise(ivec2 pixel) {
    ivec2 other = pixel + ((pixel.x + pixel.y) % 2 == 0 ? ivec2(1, 0) : ivec2(0, 1));
    vec3 a = vec3(dither_hash(uvec3(pixel, 17)) >> 8u) * (1.0 / 16777216.0);
    vec3 b = vec3(dither_hash(uvec3(other, 17)) >> 8u) * (1.0 / 16777216.0);
    return 0.5 * (a - b);
}

// A display value 0..1 with noise of at most half a step; a value that 8 bits hold exactly stays as it is.
vec3 dithered(vec3 encoded, ivec2 pixel) {
    return encoded + dither_noise(pixel) * (0.998 / 255.0);
}
