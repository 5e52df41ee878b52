// Transmittance to the top of the air by a trapezoid of 500 steps (Bruneton 2017).
#include "atmosphere/paper/mapping.glsl"
#include "atmosphere/paper/medium.glsl"
#include "atmosphere/paper/slice.glsl"

layout(rgba32f, binding = 0) writeonly uniform image2D u_transmittance;
uniform vec2 u_layout;  // what the fourth channel carries: see transmittance.glsl

const int STEPS = 500;

void main() {
    ivec3 texel;
    if (!paper_texel(texel)) {
        return;
    }
    float h, mu;
    paper_transmittance_place(vec2(texel.xy) / vec2(imageSize(u_transmittance) - 1), h, mu);
    float step_m = paper_distance_to_top(h, mu) / float(STEPS);
    vec3 sum = vec3(0.0);
    for (int i = 0; i <= STEPS; i++) {
        float weight = i == 0 || i == STEPS ? 0.5 : 1.0;
        sum += weight * paper_densities(paper_altitude_along(h, mu, float(i) * step_m));
    }
    sum *= step_m;
    vec3 depth = air_model.rayleigh_per_m * sum.x + air_model.mie_extinction_per_m * sum.y
        + air_model.absorption_per_m * sum.z;
    imageStore(u_transmittance, texel.xy, vec4(exp(-depth), texel.x == 0 ? u_layout.x : u_layout.y));
}
