// Contract "sky" (common/sky.glsl has the rules) from the printed tables.
#include "common/constants.glsl"
#include "atmosphere/paper/camera.glsl"

vec3 sky(vec3 direction) {
    PaperRay ray = paper_ray(direction);
    return max(air_sky_radiance(ray.h, ray.mu, ray.mu_s, ray.nu), 0.0) * frame.sun_irradiance
        + air_model.night_radiance;
}

vec3 sky_irradiance(vec3 point, vec3 normal) {
    vec3 up = up_at(point);
    float mu_s = clamp_cos(dot(up, frame.sun_direction)), n_up = clamp_cos(dot(normal, up));
    return frame.sun_irradiance * max(air_sky_irradiance(altitude_of(point), mu_s, n_up), 0.0)
        + air_model.night_radiance * (PI * (0.5 + 0.5 * n_up));
}
