// The lowest altitudes from which the upper (x) and the lower (y) limb of the sun's disc are seen, as far as the ground
// within 32 steps towards the sun decides: a running maximum. Each of three turns looks farther than the one before,
// m(x) = max(m(x), m seen over n, 2n and 3n steps), n = 1, then 4, then 16 (n alone). The coarser levels do the rest.
#include "shadows/march.glsl"

#ifdef FIRST
layout(binding = 0) uniform sampler2DArray u_heights;
#else
layout(binding = 0) uniform sampler2D u_limbs;
#endif
layout(binding = 0, rg32f) writeonly uniform image2D u_result;

vec2 limbs_at(ivec2 index) {
#ifdef FIRST
    return texelFetch(u_heights, shadow_texel(u_level, index), 0).rr;
#else
    return texelFetch(u_limbs, index, 0).rg;
#endif
}

void main() {
    ivec2 index = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(index, u_size))) return;
    index += u_corner;
    ShadowMarch march = shadow_march(vec2(index));
    vec2 limbs = limbs_at(index);
    int k = 1;
    do {
        limbs = max(limbs, shadow_seen(march, index, float(k * u_step)));
    } while (++k < (u_step < 16 ? 4 : 2));
    imageStore(u_result, index, vec4(limbs, 0.0, 0.0));
}
