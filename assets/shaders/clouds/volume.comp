// Volumes of noise that wrap. VOLUME 0: the shape of clouds, billows on a gradient noise that joins and parts them (the
// Perlin-Worley noise of Schneider 2015). VOLUME 1: billows alone, in three octaves, for their rims. VOLUME 2:
// clusters, in which cells still show.
// Values are raw: systems/clouds/volumes.py spreads them evenly over 0..1, so that a threshold is a share of the space.
#include "clouds/tiled_noise.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, r32f) uniform writeonly image3D o_volume;
layout(location = 0) uniform int u_first;   // slice

#if VOLUME == 0
float volume_value(vec3 p) {
    float joined = 0.0, weight = 1.0;
    int cells = 4;
    for (int k = 0; k < 3; ++k) {
        joined += weight * tiled_gradient(p * float(cells), cells, k);
        weight *= 0.5;
        cells *= 2;
    }
    float billows = 0.0;
    weight = 0.5;
    cells = 6;
    for (int k = 0; k < 4; ++k) {
        billows += weight * tiled_worley(p * float(cells), cells, 8 + k);
        weight *= 0.5;
        cells *= 2;
    }
    return joined + 1.1 * billows;
}
#elif VOLUME == 2
// Noise of all sizes from that of the cells on, as convection has them, and half as much of how far a place is from the
// seam to the next cell, in cells (Worley 1996: F2 - F1). Seams are bent by noise.
float volume_value(vec3 p) {
    vec3 bent = p + 0.05 * vec3(tiled_gradient(p * 8.0, 8, 40), tiled_gradient(p * 8.0, 8, 41),
        tiled_gradient(p * 8.0, 8, 42));
    float seams = tiled_seams(bent * 4.0, 4, 48), torn = 0.0, weight = 0.5;
    int cells = 4;
    for (int k = 0; k < 4; ++k) {
        torn += weight * tiled_gradient(p * float(cells), cells, 56 + k);
        weight *= 0.66;
        cells *= 2;
    }
    return 0.5 * min(seams, 0.5) + torn;
}
#else
float volume_value(vec3 p) {
    float billows = 0.0, weight = 0.55;
    int cells = 4;
    for (int k = 0; k < 3; ++k) {
        billows += weight * tiled_worley(p * float(cells), cells, 16 + k);
        weight *= 0.5;
        cells *= 2;
    }
    return billows;
}
#endif

void main() {
    ivec3 at = ivec3(gl_GlobalInvocationID) + ivec3(0, 0, u_first);
    ivec3 size = imageSize(o_volume);
    if (any(greaterThanEqual(at, size))) return;
    imageStore(o_volume, at, vec4(volume_value((vec3(at) + 0.5) / vec3(size))));
}
