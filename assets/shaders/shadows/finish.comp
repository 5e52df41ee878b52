// The last step of a sweep: what lies one texel towards the sun and beyond, from the running maximum and, behind its
// end or where it leaves the window, from the coarser level, which knows all that is farther; beyond the coarsest is
// the reference sphere. Writes what shaders read: height, its height above both limbs' lowest altitudes, shelter from
// the sky.
#include "shadows/march.glsl"

layout(binding = 0) uniform sampler2D u_limbs;
layout(binding = 1) uniform sampler2DArray u_coarser;
layout(binding = 2) uniform sampler2DArray u_heights;
layout(binding = 3) uniform sampler2DArray u_sky;
layout(binding = 0, rg32f) writeonly uniform image2DArray u_result;   // lowest altitudes, with this texel's own height
layout(binding = 1, rgba32f) writeonly uniform image2DArray u_map;

const float SHADOW_STEPS = 32.0;

vec2 limbs_at(ivec2 index) {
    return texelFetch(u_limbs, index, 0).rg;
}

vec2 coarse_limbs(int level, vec2 at) {
    vec2 place = clamp(at, vec2(0.0), vec2(shadow_map.window_texels) - 1.001);
    vec2 whole = floor(place), part = place - whole;
    ivec2 corner = ivec2(whole);
    vec2 a = texelFetch(u_coarser, shadow_texel(level, corner), 0).rg;
    vec2 b = texelFetch(u_coarser, shadow_texel(level, corner + ivec2(1, 0)), 0).rg;
    vec2 c = texelFetch(u_coarser, shadow_texel(level, corner + ivec2(0, 1)), 0).rg;
    vec2 d = texelFetch(u_coarser, shadow_texel(level, corner + ivec2(1, 1)), 0).rg;
    return mix(mix(a, b, part.x), mix(c, d, part.x), part.y);
}

// What the reference sphere hides from there on.
vec2 sphere_limbs(ShadowMarch march, ShadowStep advance) {
    vec2 here = -advance.versine - march.tangents * advance.sine;
    vec2 level_there = sqrt(1.0 + march.tangents * march.tangents) - 1.0;   // where the ray runs level, dip ahead
    vec2 dip = max(-march.tangents, 0.0);
    return shadow_map.radius_m * mix(here, level_there, step(vec2(advance.sine), dip * inversesqrt(1.0 + dip * dip)));
}

void main() {
    ivec2 index = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(index, u_size))) return;
    index += u_corner;
    ShadowMarch march = shadow_march(vec2(index));
    vec2 limbs = shadow_seen(march, index, 1.0);

    vec2 room = mix(vec2(index), vec2(shadow_map.window_texels - 1 - index), step(0.0, march.direction))
        / max(abs(march.direction), 1e-3);
    ShadowStep advance = shadow_step(march, clamp(floor(min(room.x, room.y)), 1.0, SHADOW_STEPS));
    vec2 at = vec2(index) + advance.offset;
    bool coarser = u_level + 1 < shadow_map.levels;
    vec2 beyond = shadow_carried(march, advance, coarse_limbs(coarser ? u_level + 1 : u_level,
        shadow_coarser(u_level, at)));
    limbs = max(limbs, coarser ? beyond : sphere_limbs(march, advance));

    ivec3 texel = shadow_texel(u_level, index);
    float height = texelFetch(u_heights, texel, 0).r;
    imageStore(u_result, texel, vec4(max(limbs, height), 0.0, 0.0));
    imageStore(u_map, texel, vec4(height, height - limbs, texelFetch(u_sky, texel, 0).r));
}
