// Contract "sun_visibility", default: the planet's own shadow and nothing else.
//
//   float sun_visibility(vec3 point)     point: camera-relative metres, planet axes. 0 (hidden) .. 1 (whole disc seen)
//   vec2  light_visibility(vec3 point)   the same, and beside it the share of the sky's light that passes the ground around
//
// The share of the disc above the geometric horizon of the reference sphere, smooth over the disc's width:
// smoothstep(-a sin_h, a sin_h, mu_s - cos_h), with the horizon at the angle whose sine is R / r (Bruneton 2017).
// Clouds are in it (contract "cloud_shadow").
// A point below the reference sphere counts as on it. Whoever provides this instead has to include the planet's shadow.
#include "common/camera.glsl"
#include "contract/cloud_shadow.glsl"

float sun_visibility_of_sphere(float altitude, float mu_s, float angular_radius) {
    float h = max(altitude, 0.0) / planet.radii.x;
    float sin_h = 1.0 / (1.0 + h);
    float cos_h = -sqrt(h * (2.0 + h)) * sin_h;
    float soft = angular_radius * sin_h;
    return smoothstep(-soft, soft, mu_s - cos_h);
}

float sun_visibility(vec3 point) {
    return sun_visibility_of_sphere(altitude_of(point), dot(up_at(point), frame.sun_direction.xyz), frame.sun_direction.w)
        * cloud_shadow(point);
}

vec2 light_visibility(vec3 point) {
    return vec2(sun_visibility(point), 1.0);
}
