// The march through homogeneous shells.
#include "clouds/uniform.glsl"
#include "clouds/march.glsl"

float cloud_extinction(int layer, CloudRay ray, float t, float share) {
    float s = 2.0 * share - 1.0;
    return cloud_model.shells[layer].w * (cloud_model.droplets[layer].z > 0.5 ? max(1.0 - s * s, 0.0) : 1.0);
}

float cloud_sun_depth(CloudRay ray, float t, ShellRay sun) {
    return cloud_uniform_depth(sun, 0.0, 1e30);
}

vec2 cloud_column(CloudRay ray, float t, float h) {
    vec2 found = vec2(0.0);
    for (int layer = 0; layer < cloud_model.counts.x; ++layer) {
        vec4 shell = cloud_model.shells[layer];
        float share = clamp(cloud_share(layer, h), 0.0, 1.0);
        // Integral of the profile from the base up: of 4 s (1 - s), or of 1.
        bool parabola = cloud_model.droplets[layer].z > 0.5;
        float below = parabola ? share * share * (2.0 - 4.0 / 3.0 * share) : share, whole = parabola ? 2.0 / 3.0 : 1.0;
        found += shell.w * (shell.y - shell.x) * vec2(whole - below, below);
    }
    return found;
}
