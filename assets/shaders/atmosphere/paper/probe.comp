// The printed method's functions on an array of questions.
#include "atmosphere/paper/functions.glsl"
#include "atmosphere/question.glsl"

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(u_mode.y)) return;
    Question q = questions[i];
    float h = q.camera.x, mu_s = q.camera.y, mu = q.ray.x, nu = q.ray.w;
    vec3 transmittance = vec3(1.0), first = vec3(0.0), second = vec3(0.0);
    if (u_mode.x == TO_SPACE) {
        transmittance = air_transmittance_to_space(h, mu);
    } else if (u_mode.x == SURFACE) {
        float radius = air_model.sun_radius_rad, rising = q.more.z + radius;
        float facing = q.more.z >= radius ? q.more.z : q.more.z <= -radius ? 0.0 : rising * rising / (4.0 * radius);
        float unused = 0.0, distance_m, height = h, sun = mu_s;
        bool inside = paper_enter(height, sun, unused, 0.0, distance_m);
        bool hidden = h > paper_thickness() && inside && paper_hits_floor(height, sun);
        vec3 through = inside ? paper_transmittance_to_top(height, max(sun, paper_horizon(height))) : vec3(1.0);
        first = hidden ? vec3(0.0) : through * facing;
        second = air_sky_irradiance(h, mu_s, q.more.x);
    } else if (q.more.x >= 0.0) {
        air_segment(h, mu, mu_s, nu, q.more.x, transmittance, first);
    } else {
        air_sky(h, mu, mu_s, nu, first, second, transmittance);
        if (u_mode.w == 0) first /= paper_rayleigh_phase(nu);
    }
    answer(i, transmittance, first, second, paper_mie_phase(nu));
}
