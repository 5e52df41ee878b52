// The camera's ray and the sun as the printed functions take them.
#include "common/camera.glsl"
#include "atmosphere/paper/functions.glsl"

struct PaperRay {
    float h, mu, mu_s, nu;
};

PaperRay paper_ray(vec3 direction) {
    vec3 up = frame.camera_zenith, sun = frame.sun_direction;
    return PaperRay(frame.camera_altitude_m, clamp_cos(dot(direction, up)), clamp_cos(dot(sun, up)),
        clamp_cos(dot(direction, sun)));
}
