// How a ray is cut into slices: dense about its lowest point (where the air is), nearly by squares of the distance from
// it. The two sides join smoothly, so that rays just above and just below the level differ little at the same slice.
#include "atmosphere/medium.glsl"

const float AIR_SLICE_SOFT = 0.005;   // of the path: nearer to the lowest point than this, slices are even

// Measure of a distance from the lowest point, and back.
float air_slice_measure(float x, float soft) {
    return x / max(sqrt(x + soft) + sqrt(soft), 1e-10);
}

float air_slice_inverse(float g, float soft) {
    return g * (g + 2.0 * sqrt(soft));
}

// Share of the slices that lie before the lowest point.
float air_split(float lowest, float path) {
    float soft = AIR_SLICE_SOFT * path;
    float down = air_slice_measure(lowest, soft), up = air_slice_measure(max(path - lowest, 0.0), soft);
    return down / max(down + up, 1e-10);
}

// Distance along the ray of a share w of its slices.
float air_slice_distance(float w, float path, float lowest, float split) {
    float soft = AIR_SLICE_SOFT * path;
    float whole = air_slice_measure(lowest, soft) + air_slice_measure(max(path - lowest, 0.0), soft);
    float away = air_slice_inverse(abs(w - split) * whole, soft);
    return clamp(w < split ? lowest - away : lowest + away, 0.0, path);
}

// The share w of a distance.
float air_slice_of(float t, float path, float lowest, float split) {
    float soft = AIR_SLICE_SOFT * path;
    float whole = air_slice_measure(lowest, soft) + air_slice_measure(max(path - lowest, 0.0), soft);
    float away = air_slice_measure(abs(t - lowest), soft) / max(whole, 1e-10);
    return clamp(t < lowest ? split - away : split + away, 0.0, 1.0);
}

// Parts that each slice is integrated in: one that is thick itself hides what two nodes miss.
int air_slice_parts() {
    vec3 depth = air_model.rayleigh_per_m * air_model.rayleigh_height_m
        + air_model.mie_extinction_per_m * air_model.mie_height_m
        + air_model.absorption_per_m / max(air_model.absorber_slope_per_m, 1e-20);
    return int(clamp(ceil(0.4 * max(max(depth.r, depth.g), depth.b)), 1.0, 3.0));
}

// Optical depth of one slice by Gauss's rule of two points; end: where it ends.
vec3 air_slice_depth(float h, float mu, float path, float lowest, float split, int slice, int slices, out float end) {
    float t0 = air_slice_distance(float(slice) / float(slices), path, lowest, split);
    end = air_slice_distance(float(slice + 1) / float(slices), path, lowest, split);
    float dt = end - t0;
    vec3 a = air_extinction(air_density(air_height_along(h, mu, t0 + 0.211324865 * dt)));
    vec3 b = air_extinction(air_density(air_height_along(h, mu, t0 + 0.788675135 * dt)));
    return 0.5 * dt * (a + b);
}
