// Shelter from the sky: how much of the sky's light reaches a texel past the ground around it, as a share of what a
// slope of its own would get among no others. Horizons in eight directions, from this level's neighbours and, farther
// away, from the coarser level's horizons; in each the cosine to the normal is integrated from the horizon up.
#include "shadows/clipmap.glsl"

layout(local_size_x = 16, local_size_y = 4) in;
layout(binding = 0) uniform sampler2DArray u_heights;
layout(binding = 1) uniform usampler2DArray u_coarser;
layout(binding = 0, rgba32ui) writeonly uniform uimage2DArray u_horizons;
layout(binding = 1, r8) writeonly uniform image2DArray u_sky;
uniform ivec2 u_corner;   // of the texels to make in the window
uniform ivec2 u_size;     // how many there are
uniform int u_level;

const ivec2 AROUND[8] = ivec2[8](ivec2(1, 0), ivec2(1, 1), ivec2(0, 1), ivec2(-1, 1), ivec2(-1, 0), ivec2(-1, -1),
    ivec2(0, -1),
    ivec2(1, -1));

float height_at(ivec2 index) {
    index = clamp(index, ivec2(0), ivec2(shadow_map.window_texels - 1));
    return texelFetch(u_heights, shadow_texel(u_level, index), 0).r;
}

// Integral over the elevation from the angle with tangent t up to the zenith of (n_up sin + n_side cos) cos.
float sky_share(float t, float n_up, float n_side) {
    float cosine2 = 1.0 / (1.0 + t * t);
    return 0.5 * n_up * cosine2 + 0.5 * n_side * (1.57079632679 - atan(t) - t * cosine2);
}

void main() {
    ivec2 index = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(index, u_size))) return;
    index += u_corner;
    ShadowFoot foot = shadow_foot(u_level, vec2(index));
    float radius = shadow_map.radius_m;
    float spacing = 2.0 * radius / (shadow_frequency(u_level) * foot.bulge);
    float here = height_at(index);
    vec2 slope = 0.5 / spacing * vec2(height_at(index + ivec2(1, 0)) - height_at(index - ivec2(1, 0)),
        height_at(index + ivec2(0, 1)) - height_at(index - ivec2(0, 1)));
    float n_up = inversesqrt(1.0 + dot(slope, slope));
    bool has_coarser = u_level + 1 < shadow_map.levels;

    // The coarser level's horizons begin two of its texels away; its ground there may lie higher or lower than here.
    float far_tangent[8] = float[8](-1.0, -1.0, -1.0, -1.0, -1.0, -1.0, -1.0, -1.0);
    int turns = has_coarser ? 4 : 0, turn = 0;
    vec2 at = has_coarser ? shadow_coarser(u_level, vec2(index)) : vec2(0.0);
    vec2 whole = floor(at), part = at - whole;
    for (int i = 0; i < 8; ++i) far_tangent[i] = has_coarser ? 0.0 : -1.0;
    for (; turn < turns; ++turn) {
        ivec2 side = ivec2(turn & 1, turn >> 1);
        vec2 weights = mix(1.0 - part, part, vec2(side));
        float weight = weights.x * weights.y;
        ivec2 corner = clamp(ivec2(whole) + side, ivec2(0), ivec2(shadow_map.window_texels - 1));
        ivec3 texel = shadow_texel(u_level + 1, corner);
        uvec4 coded = texelFetch(u_coarser, texel, 0);
        float lift = (texelFetch(u_heights, texel, 0).r - here) / (8.0 * spacing);
        for (int i = 0; i < 4; ++i) {
            vec2 pair = unpackHalf2x16(coded[i]);
            far_tangent[2 * i] += weight * (pair.x + lift);
            far_tangent[2 * i + 1] += weight * (pair.y + lift);
        }
    }

    float sky = 0.0, whole_sky = 0.0;
    uvec4 coded_horizons = uvec4(0u);
    for (int i = 0; i < 8; ++i) {
        float reach = spacing * length(vec2(AROUND[i]));
        float tangent = far_tangent[i];
        for (int n = 1; n < 4; ++n) {
            float away = reach * float(n);
            tangent = max(tangent, (height_at(index + n * AROUND[i]) - here) / away - 0.5 * away / radius);
        }
        // its own plane hides what lies below this tangent, and the level horizon
        float side = dot(slope, normalize(vec2(AROUND[i])));
        float n_side = -side * n_up;
        whole_sky += sky_share(max(side, 0.0), n_up, n_side);
        sky += sky_share(max(max(tangent, side), 0.0), n_up, n_side);
        uint half_bits = packHalf2x16(vec2(clamp(tangent, -100.0, 100.0), 0.0)) & 0xffffu;
        coded_horizons[i >> 1] |= half_bits << (16 * (i & 1));
    }
    ivec3 texel = shadow_texel(u_level, index);
    imageStore(u_horizons, texel, coded_horizons);
    imageStore(u_sky, texel, vec4(clamp(sky / max(whole_sky, 1e-4), 0.0, 1.0)));
}
