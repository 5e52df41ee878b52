// Homogeneous shells: optical depths in closed form. Along a ray the profile is a polynomial of degree 4 in the
// distance (and curvature beyond that), for which Gauss's rule of three points is exact.
#include "clouds/droplets.glsl"

// Mean of a layer's profile between two distances that both lie in it.
float cloud_mean_profile(int layer, ShellRay ray, float from, float to) {
    if (!cloud_model.layers[layer].parabola) return 1.0;
    float middle = 0.5 * (from + to), away = 0.387298335 * (to - from), sum = 0.0;
    for (int k = -1; k <= 1; ++k) {
        float s = 2.0 * cloud_share(layer, shell_height(ray, middle + float(k) * away)) - 1.0;
        sum += (k == 0 ? 4.0 : 2.5) * max(1.0 - s * s, 0.0);
    }
    return sum / 9.0;
}

// Optical depth of one layer between two distances along a ray.
float cloud_layer_depth(int layer, ShellRay ray, float from, float to) {
    vec4 intervals = shell_intervals(ray, cloud_model.layers[layer].base_m, cloud_model.layers[layer].top_m);
    intervals = clamp(intervals, from, to);
    float depth = 0.0;
    for (int k = 0; k < 2; ++k) {
        float a = intervals[2 * k], b = intervals[2 * k + 1];
        if (b > a) depth += (b - a) * cloud_mean_profile(layer, ray, a, b);
    }
    return depth * cloud_model.layers[layer].extinction_per_m;
}

// Of all layers.
float cloud_uniform_depth(ShellRay ray, float from, float to) {
    float depth = 0.0;
    for (int layer = 0; layer < cloud_model.layer_count; ++layer) depth += cloud_layer_depth(layer, ray, from, to);
    return depth;
}
