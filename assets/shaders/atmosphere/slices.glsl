// How a ray is cut into slices: dense about its lowest point (where the air is), by squares of the distance from it, and shared
// out between the two sides by the square root of their lengths.
#include "atmosphere/medium.glsl"

float air_split(float lowest, float path) {
    float down = sqrt(lowest), up = sqrt(max(path - lowest, 0.0));
    return down / max(down + up, 1e-10);
}

// Distance along the ray of a share w of its slices, and back.
float air_slice_distance(float w, float path, float lowest, float split) {
    float down = clamp((split - w) / max(split, 1e-6), 0.0, 1.0), up = clamp((w - split) / max(1.0 - split, 1e-6), 0.0, 1.0);
    return lowest - lowest * down * down + (path - lowest) * up * up;
}

float air_slice_of(float t, float path, float lowest, float split) {
    float down = sqrt(clamp((lowest - t) / max(lowest, 1e-6), 0.0, 1.0));
    float up = sqrt(clamp((t - lowest) / max(path - lowest, 1e-6), 0.0, 1.0));
    return split - split * down + (1.0 - split) * up;
}
