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

vec3 cloud_before(CloudRay ray, int layer, float t, ShellRay sun, float share, vec3 sunlight, vec3 ambient) {
    return vec3(0.0);
}
