// Irradiance of a level surface by the sun itself, with the mean cosine over the part of the disc that is up (Bruneton
// 2017). It lights the floor for the second order; it is no part of the sky's irradiance, whose sum begins with 0.
#include "atmosphere/paper/transmittance.glsl"
#include "atmosphere/paper/slice.glsl"

layout(rgba32f, binding = 0) writeonly uniform image2D u_order;
layout(rgba32f, binding = 1) writeonly uniform image2D u_irradiance;

void main() {
    ivec3 texel;
    if (!paper_texel(texel)) {
        return;
    }
    vec2 unit = vec2(texel.xy) / vec2(imageSize(u_order) - 1);
    float h = unit.y * paper_thickness();
    float mu_s = 2.0 * unit.x - 1.0;
    float a = air_model.sun_radius_rad;
    float rising = safe_divide((mu_s + a) * (mu_s + a), 4.0 * a, 0.0);
    float cosine = mu_s < -a ? 0.0 : mu_s > a ? mu_s : rising;
    vec3 sun = paper_transmittance_to_top(h, max(mu_s, paper_horizon(h))) * cosine;
    imageStore(u_order, texel.xy, vec4(sun, 0.0));
    imageStore(u_irradiance, texel.xy, vec4(0.0));
}
