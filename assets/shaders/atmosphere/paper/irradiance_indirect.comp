// Irradiance of a level surface by one order of sky light, from 16 x 64 directions above it (Bruneton 2017).
// FIRST_ORDER: that order is single scattering, in two tables and without its phase functions.
#include "generated/bindings.glsl"
#include "common/constants.glsl"
#include "atmosphere/paper/transmittance.glsl"
#include "atmosphere/paper/medium.glsl"
#include "atmosphere/paper/slice.glsl"

layout(rgba32f, binding = 0) writeonly uniform image2D u_order;
layout(rgba32f, binding = 1) uniform image2D u_irradiance;
layout(binding = PAPER_MIE_UNIT) uniform sampler3D u_mie;
layout(binding = PAPER_BEFORE_UNIT) uniform sampler3D u_before;

const int CONES = 16;
const int AROUND = 64;

vec3 read(sampler3D table, PaperPlace place) {
    return mix(textureLod(table, place.first, 0.0).rgb, textureLod(table, place.second, 0.0).rgb, place.blend);
}

void main() {
    ivec3 texel;
    if (!paper_texel(texel)) {
        return;
    }
    PaperLayout layout_ = paper_layout();
    ivec3 size = textureSize(u_before, 0);
    vec2 unit = vec2(texel.xy) / vec2(imageSize(u_order) - 1);
    float h = unit.y * paper_thickness();
    float mu_s = 2.0 * unit.x - 1.0;
    float sun_x = sin_from_cos(mu_s);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < CONES * AROUND; i++) {
        float theta = (float(i / AROUND) + 0.5) * HALF_PI / float(CONES);
        float phi = (float(i % AROUND) + 0.5) * 2.0 * PI / float(AROUND);
        float up = cos(theta);
        float aside = sin(theta);
        float nu = clamp_cos(cos(phi) * aside * sun_x + up * mu_s);
        PaperPlace place = paper_scattering_place(layout_, size, h, up, mu_s, nu, false);
        vec3 light = read(u_before, place);
#ifdef FIRST_ORDER
        light = light * paper_rayleigh_phase(nu) + read(u_mie, place) * paper_mie_phase(nu);
#endif
        sum += light * up * aside;
    }
    sum *= HALF_PI / float(CONES) * 2.0 * PI / float(AROUND);
    imageStore(u_order, texel.xy, vec4(sum, 0.0));
    imageStore(u_irradiance, texel.xy, vec4(imageLoad(u_irradiance, texel.xy).rgb + sum, 0.0));
}
