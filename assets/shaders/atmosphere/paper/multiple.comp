// The next order: what is scattered along a ray, by a trapezoid of 50 steps (Bruneton 2017); added to the sum of orders
// divided by the Rayleigh phase function, by which the sum is multiplied when it is read.
#include "generated/bindings.glsl"
#include "atmosphere/paper/transmittance.glsl"
#include "atmosphere/paper/medium.glsl"
#include "atmosphere/paper/slice.glsl"

layout(PAPER_FORMAT, binding = 0) writeonly uniform image3D u_order;
layout(PAPER_FORMAT, binding = 1) uniform image3D u_scattering;
layout(binding = PAPER_DENSITY_UNIT) uniform sampler3D u_density;

const int STEPS = 50;

void main() {
    ivec3 texel;
    if (!paper_texel(texel)) {
        return;
    }
    ivec3 size = imageSize(u_order);
    PaperLayout layout_ = paper_layout();
    float h, mu, mu_s, nu;
    bool hits_floor;
    paper_scattering_texel(layout_, size, texel, h, mu, mu_s, nu, hits_floor);
    float step_m = paper_distance_to_boundary(h, mu, hits_floor) / float(STEPS);
    vec3 here = paper_transmittance_to_top(h, hits_floor ? -mu : mu);
    vec3 sum = vec3(0.0);
    for (int i = 0; i <= STEPS; i++) {
        float weight = i == 0 || i == STEPS ? 0.5 : 1.0;
        float along = float(i) * step_m;
        float h_there = paper_altitude_along(h, mu, along);
        float mu_there = paper_cosine_along(h, mu, along, h_there);
        vec3 there = paper_transmittance_to_top(h_there, hits_floor ? -mu_there : mu_there);
        vec3 between = hits_floor ? there / max(here, vec3(1e-37)) : here / max(there, vec3(1e-37));
        float sun_there = paper_cosine_along(h, mu_s, along * nu, h_there);
        PaperPlace place = paper_scattering_place(layout_, size, h_there, mu_there, sun_there, nu, hits_floor);
        vec3 source = mix(
            textureLod(u_density, place.first, 0.0).rgb, textureLod(u_density, place.second, 0.0).rgb, place.blend
        );
        sum += weight * min(between, vec3(1.0)) * source;
    }
    sum *= step_m * air_model.per_thickness;
    imageStore(u_order, texel, vec4(paper_stored(sum), 0.0));
    vec3 total = imageLoad(u_scattering, texel).rgb + sum / paper_rayleigh_phase(nu);
    imageStore(u_scattering, texel, vec4(paper_stored(total), 0.0));
}
