// Contract "air" (common/air.glsl has the rules) from the printed tables. What comes out negative is shown as black: a
// picture cannot show less.
#include "atmosphere/paper/camera.glsl"

struct Air {
    vec3 transmittance;
    vec3 in_scatter;
};

Air air_from_camera(vec3 to) {
    float distance_m = length(to);
    PaperRay ray = paper_ray(to / max(distance_m, 1e-20));
    Air between;
    air_segment(ray.h, ray.mu, ray.mu_s, ray.nu, distance_m, between.transmittance, between.in_scatter);
    between.in_scatter = max(between.in_scatter, 0.0) * frame.sun_irradiance;
    return between;
}

Air air(vec3 from, vec3 to) {
    Air near = air_from_camera(from), far = air_from_camera(to);
    vec3 to_near = max(near.transmittance, 1e-20);
    return Air(min(far.transmittance / to_near, 1.0), max((far.in_scatter - near.in_scatter) / to_near, 0.0));
}

vec3 air_to_space(vec3 from, vec3 direction) {
    float h = altitude_of(from), mu = clamp_cos(dot(direction, up_at(from))), unused = 0.0, distance_m;
    if (!paper_enter(h, mu, unused, 0.0, distance_m)) return vec3(1.0);
    return paper_transmittance_to_top(h, max(mu, paper_horizon(h)));
}
