// The clipmap's geometry: texels on a stereographic map, levels whose spacing doubles, windows that wrap around.
// Coordinates of a level are in texels from the corner of its window; texel (i, j) lies at coordinates (i, j).
#include "generated/shadow_map.glsl"

// Place on the map, relative to the anchor's, of a foot offset D (see camera.glsl).
vec2 shadow_place(vec3 D) {
    vec3 local = vec3(dot(shadow_map.axis_x, D), dot(shadow_map.axis_y, D), dot(shadow_map.axis_z, D));
    return (local.xy - shadow_map.anchor_place * local.z)
        / max(shadow_map.anchor_divisor * shadow_map.radius_m + local.z, 1e-6 * shadow_map.radius_m);
}

// Texels of a level per length on the map.
float shadow_frequency(int level) {
    return shadow_map.frequency * exp2(-float(level));
}

// Where texel (i, j) of a window is stored.
ivec3 shadow_texel(int level, ivec2 index) {
    ivec2 at = index + shadow_map.windows[level].stored;
    return ivec3(at & (shadow_map.side - 1), (shadow_map.power - level) & 15);
}

// Coordinates in the next coarser level.
vec2 shadow_coarser(int level, vec2 at) {
    int next = min(level + 1, shadow_map.levels - 1);
    return 0.5 * (at - shadow_map.windows[level].anchor) + shadow_map.windows[next].anchor;
}

// Direction (projection's axes) and foot offset (planet axes) of coordinates of a level, and 1 + |p|^2 there.
// Differences from the anchor are formed without cancellation.
struct ShadowFoot {
    vec3 up;      // projection's axes
    vec3 D;       // planet axes, metres
    vec2 place;   // p
    float bulge;  // 1 + |p|^2: metres per texel are 2 R / (frequency * bulge)
};

ShadowFoot shadow_foot(int level, vec2 at) {
    vec2 p0 = shadow_map.anchor_place;
    vec2 dp = (at - shadow_map.windows[level].anchor) / shadow_frequency(level);
    float bulge0 = 1.0 + dot(p0, p0), dw = dot(dp, 2.0 * p0 + dp);
    ShadowFoot foot;
    foot.bulge = bulge0 + dw;
    foot.place = p0 + dp;
    float scale = 2.0 / (bulge0 * foot.bulge);
    vec3 d = vec3((dp * bulge0 - p0 * dw) * scale, -dw * scale);
    foot.up = vec3(2.0 * foot.place, 2.0 - foot.bulge) / foot.bulge;
    foot.D = shadow_map.radius_m * (shadow_map.axis_x * d.x + shadow_map.axis_y * d.y + shadow_map.axis_z * d.z);
    return foot;
}
