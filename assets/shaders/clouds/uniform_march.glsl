// The march through homogeneous shells.
#include "clouds/uniform.glsl"
#include "clouds/march.glsl"

float cloud_extinction(int layer, CloudRay ray, float t, float share) {
    CloudModelLayer shell = cloud_model.layers[layer];
    float s = 2.0 * share - 1.0;
    return shell.extinction_per_m * (shell.parabola ? max(1.0 - s * s, 0.0) : 1.0);
}

float cloud_sun_depth(CloudRay ray, float t, ShellRay sun) {
    return cloud_uniform_depth(sun, 0.0, 1e30);
}

vec2 cloud_column(CloudRay ray, float t, float h) {
    vec2 found = vec2(0.0);
    for (int layer = 0; layer < cloud_model.layer_count; ++layer) {
        CloudModelLayer shell = cloud_model.layers[layer];
        float share = clamp(cloud_share(layer, h), 0.0, 1.0);
        // Integral of the profile from the base up: of 4 s (1 - s), or of 1.
        float below = shell.parabola ? share * share * (2.0 - 4.0 / 3.0 * share) : share,
            whole = shell.parabola ? 2.0 / 3.0 : 1.0;
        found += shell.extinction_per_m * (shell.top_m - shell.base_m) * vec2(whole - below, below);
    }
    return found;
}
