// The printed method's functions on an array of questions.
#include "atmosphere/paper/functions.glsl"
#include "atmosphere/question.glsl"

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(u_count)) return;
    AirQuestion q = questions[i];
    float h = q.altitude_m, mu_s = q.sun_mu, mu = q.mu, nu = q.nu;
    vec3 transmittance = vec3(1.0), first = vec3(0.0), second = vec3(0.0);
    if (u_asked == TO_SPACE) {
        transmittance = air_transmittance_to_space(h, mu);
    } else if (u_asked == SURFACE) {
        float radius = air_model.sun_radius_rad, cosine = q.sun_cosine, rising = cosine + radius;
        float facing = cosine >= radius ? cosine : cosine <= -radius ? 0.0 : rising * rising / (4.0 * radius);
        float unused = 0.0, distance_m, height = h, sun = mu_s;
        bool inside = paper_enter(height, sun, unused, 0.0, distance_m);
        bool hidden = h > paper_thickness() && inside && paper_hits_floor(height, sun);
        vec3 through = inside ? paper_transmittance_to_top(height, max(sun, paper_horizon(height))) : vec3(1.0);
        first = hidden ? vec3(0.0) : through * facing;
        second = air_sky_irradiance(h, mu_s, q.n_up);
    } else if (q.distance_m >= 0.0) {
        air_segment(h, mu, mu_s, nu, q.distance_m, transmittance, first);
    } else {
        air_sky(h, mu, mu_s, nu, first, second, transmittance);
        if (!u_phase) first /= paper_rayleigh_phase(nu);
    }
    answer(i, transmittance, first, second, paper_mie_phase(nu));
}
