// The share of the sun's disc above the geometric horizon of the reference sphere, smooth over the disc's width:
// smoothstep(-a sin_h, a sin_h, mu_s - cos_h), with the horizon at the angle whose sine is R / r (Bruneton 2017).
// A point below the reference sphere counts as on it.
#include "common/camera.glsl"

float sun_visibility_of_sphere(float altitude, float mu_s, float angular_radius) {
    float h = max(altitude, 0.0) / planet.radius_m;
    float sin_h = 1.0 / (1.0 + h);
    float cos_h = -sqrt(h * (2.0 + h)) * sin_h;
    float soft = angular_radius * sin_h;
    return smoothstep(-soft, soft, mu_s - cos_h);
}
