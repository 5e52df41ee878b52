// sky_irradiance() of the contract "sky" (common/sky.glsl has the rules), from the table of irradiance.
#include "common/constants.glsl"
#include "common/camera.glsl"
#include "atmosphere/irradiance.glsl"

vec3 sky_irradiance(vec3 point, vec3 normal) {
    float h = clamp(altitude_of(point), 0.0, air_model.thickness_m);
    vec3 up = up_at(point);
    float mu_s = clamp_cos(dot(up, frame.sun_direction)), n_up = clamp_cos(dot(normal, up));
    // The sun in the zenith: no azimuth, and walls all around are equally bright.
    vec3 side = safe_normalize(frame.sun_direction - up * mu_s, vec3(0.0));
    return frame.sun_irradiance * air_sky_light(h, mu_s, n_up, dot(normal, side))
        + air_model.night_radiance * (PI * (0.5 + 0.5 * n_up));
}
