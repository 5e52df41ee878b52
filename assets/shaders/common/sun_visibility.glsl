// Contract "sun_visibility", default: the planet's own shadow and nothing else.
//
//   float sun_visibility(vec3 point)     point: camera-relative metres, planet axes. 0 (hidden) .. 1 (whole disc seen)
//   vec2  light_visibility(vec3 point)   the same, and beside it the share of the sky's light that passes the ground
//   around
//
// Clouds are in it (contract "cloud_shadow"). Whoever provides this instead has to include the planet's shadow.
#include "common/camera.glsl"
#include "common/planet_shadow.glsl"
#include "contract/cloud_shadow.glsl"

float sun_visibility(vec3 point) {
    return sun_visibility_of_sphere(altitude_of(point), dot(up_at(point), frame.sun_direction),
        frame.sun_radius_rad)
        * cloud_shadow(point);
}

vec2 light_visibility(vec3 point) {
    return vec2(sun_visibility(point), 1.0);
}
