// Contract "cover_light" of the map of the trees' shadows: metres towards the sun of the highest leaf, over a square
// around the camera that faces the sun.
#include "generated/bindings.glsl"
#include "generated/frame.glsl"
#include "generated/cover_map.glsl"

layout(binding = COVER_UNIT) uniform sampler2D u_cover_map;

const float COVER_LEAKS = 0.06;   // of the sun through a crown

float cover_light(vec3 point, float bias) {
    vec3 at = point - cover_map.middle_m;
    vec2 place = vec2(dot(at, cover_map.x), dot(at, cover_map.y)) * cover_map.per_m;
    float edge = max(abs(place.x), abs(place.y));
    if (edge >= 1.0) return 1.0;
    float along = dot(at, frame.sun_direction) + bias;
    ivec2 last = textureSize(u_cover_map, 0) - 1;
    vec2 texel = (0.5 * place + 0.5) * vec2(last + 1) - 0.5, whole = floor(texel), f = texel - whole;
    ivec2 first = ivec2(whole);
    vec4 high = vec4(texelFetch(u_cover_map, clamp(first, ivec2(0), last), 0).r,
        texelFetch(u_cover_map, clamp(first + ivec2(1, 0), ivec2(0), last), 0).r,
        texelFetch(u_cover_map, clamp(first + ivec2(0, 1), ivec2(0), last), 0).r,
        texelFetch(u_cover_map, clamp(first + 1, ivec2(0), last), 0).r);
    // As deep in leaves as a texel or two it is dark.
    vec4 dark = clamp((high - along) * cover_map.per_depth_m, 0.0, 1.0);
    float shade = mix(mix(dark.x, dark.y, f.x), mix(dark.z, dark.w, f.x), f.y);
    return 1.0 - (1.0 - COVER_LEAKS) * shade * clamp(8.0 - 8.0 * edge, 0.0, 1.0);
}
