// Single scattering by molecules and by aerosols, without phase functions, by a trapezoid of 50 steps (Bruneton 2017).
#include "atmosphere/paper/transmittance.glsl"
#include "atmosphere/paper/medium.glsl"
#include "atmosphere/paper/slice.glsl"

layout(PAPER_FORMAT, binding = 0) writeonly uniform image3D u_rayleigh;    // for the next order
layout(PAPER_FORMAT, binding = 1) writeonly uniform image3D u_mie;
layout(PAPER_FORMAT, binding = 2) writeonly uniform image3D u_scattering;  // the sum of orders begins here

const int STEPS = 50;

void main() {
    ivec3 texel;
    if (!paper_texel(texel)) {
        return;
    }
    float h, mu, mu_s, nu;
    bool hits_floor;
    paper_scattering_texel(paper_layout(), imageSize(u_rayleigh), texel, h, mu, mu_s, nu, hits_floor);
    float step_m = paper_distance_to_boundary(h, mu, hits_floor) / float(STEPS);
    // The camera's look-up of the quotient that is the transmittance; the other one is done at every step.
    vec3 here = paper_transmittance_to_top(h, hits_floor ? -mu : mu);
    vec3 rayleigh = vec3(0.0), mie = vec3(0.0);
    for (int i = 0; i <= STEPS; i++) {
        float weight = i == 0 || i == STEPS ? 0.5 : 1.0;
        float along = float(i) * step_m;
        float h_there = paper_altitude_along(h, mu, along);
        float mu_there = paper_cosine_along(h, mu, along, h_there);
        vec3 there = paper_transmittance_to_top(h_there, hits_floor ? -mu_there : mu_there);
        vec3 between = hits_floor ? there / max(here, vec3(1e-37)) : here / max(there, vec3(1e-37));
        float sun_there = paper_cosine_along(h, mu_s, along * nu, h_there);
        vec3 light = weight * min(between, vec3(1.0)) * paper_sun_transmittance(h_there, sun_there);
        vec3 density = paper_densities(h_there);
        rayleigh += light * density.x;
        mie += light * density.y;
    }
    rayleigh = paper_stored(rayleigh * step_m * air_model.rayleigh_per_m);
    mie = paper_stored(mie * step_m * air_model.mie_scattering_per_m);
    imageStore(u_rayleigh, texel, vec4(rayleigh, 0.0));
    imageStore(u_mie, texel, vec4(mie, 0.0));
    imageStore(u_scattering, texel, vec4(rayleigh, 0.0));
}
