// Contract "air" (common/air.glsl has the rules) for a probe's questions, without a camera's tables: the air is
// marched.
#include "common/camera.glsl"
#include "atmosphere/source.glsl"

struct Air {
    vec3 transmittance, in_scatter;
};

Air air_from_camera(vec3 to) {
    float distance_m = length(to), h = max(frame.camera_altitude_m, 0.0), r = air_model.radius_m + h, start = 0.0;
    vec3 ray = to / max(distance_m, 1e-20), up = frame.camera_zenith;
    float mu = clamp_cos(dot(ray, up)), nu = clamp_cos(dot(ray, frame.sun_direction)),
        mu_s = dot(up, frame.sun_direction);
    float path = 0.0;
    if (h > air_model.thickness_m) {
        // From space, as in air_path(): the exact place of entry.
        float miss = r * length(ray - up * dot(ray, up));
        float inside2 = (air_model.top_radius_m - miss) * (air_model.top_radius_m + miss);
        float half_chord = safe_sqrt(inside2);
        bool meets = mu < 0.0 && inside2 > 0.0;
        start = meets ? max(-r * mu - half_chord, 0.0) : 0.0;
        path = meets ? 2.0 * half_chord : 0.0;
        h = air_model.thickness_m;
        mu_s = (r * mu_s + start * nu) / air_model.top_radius_m;
        mu = -half_chord / air_model.top_radius_m;
    } else {
        path = air_to_top(h, mu);
    }
    float to_floor = air_to_floor(h, mu);
    path = min(to_floor >= 0.0 && path > 0.0 ? to_floor : path, max(distance_m - start, 0.0));
    AirColumn c = air_column(h, mu, clamp_cos(mu_s), nu, path);
    air_orders = PROBE_ORDERS;
    for (int slice = 0; slice < (path > 0.0 ? PROBE_SLICES : 0); ++slice) air_column_slice(c, slice, PROBE_SLICES);
    return Air(exp(-c.depth), frame.sun_irradiance
        * (air_rayleigh_phase(nu) * c.first + air_mie_phase(nu) * c.second));
}

Air air(vec3 from, vec3 to) {
    Air near = air_from_camera(from), far = air_from_camera(to);
    vec3 to_near = max(near.transmittance, 1e-20);
    return Air(min(far.transmittance / to_near, 1.0), max((far.in_scatter - near.in_scatter) / to_near, 0.0));
}

#include "atmosphere/to_space.glsl"
