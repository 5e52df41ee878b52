// Any resource as a picture. MODE says how (systems/debug/views.py); what isn't a finite number is magenta.
#include "common/camera.glsl"
#include "common/color.glsl"
#include "common/octahedral.glsl"
#include "common/spacing_code.glsl"
#include "composite/resolved.glsl"
#include "debug/source.glsl"

#define MODE_COLOR 0      // as it is
#define MODE_RANGE 1      // colours stretched from the smallest to the largest value
#define MODE_HEAT 2       // one number, likewise, as heat
#define MODE_SIGNED 3     // -1..1 to 0..1
#define MODE_NORMAL 4     // octahedral normal, planet axes: xyz as rgb; black where nothing is
#define MODE_DEPTH 5      // reversed depth: logarithm of the distance along forward, over the range of the picture
#define MODE_DISTANCE 6   // likewise along the ray
#define MODE_IDS 7        // whole numbers: a colour each
#define MODE_LOD 8        // spacing of vertices, in alpha: a colour for each doubling
#define MODE_HDR 9        // luminance in stops as heat, over the range of the picture
#define MODE_PX 10        // pixels of error: 0.01 to 10, logarithmic
// frames that light was gathered over, in alpha (composite/resolved.glsl): red 1, green 16 and more
#define MODE_HISTORY 12
#define MODE_SURFACE 11   // what a pixel shows: ground green, sea blue, props red
#define MODE_SLOPE 13     // from a normal: 0 to 90 degrees as heat
#define MODE_SHARE 14     // 0..1 as grey
#define MODE_ALBEDO 15    // linear colours
#define MODE_MATERIAL 16  // number of a material, in alpha: a colour each

layout(std430, binding = 5) readonly buffer RangeIn { vec2 r_range; };
layout(binding = 1) uniform sampler2D u_depth;
in vec2 v_uv;
in vec2 v_ndc;
layout(location = 0) out vec4 o_color;

// 0..1: black, blue, violet, red, orange, yellow, white.
vec3 heat(float t) {
    const vec3 STOPS[7] = vec3[7](vec3(0.0), vec3(0.07, 0.10, 0.45), vec3(0.45, 0.08, 0.55), vec3(0.85, 0.18, 0.25),
                                  vec3(0.98, 0.52, 0.10), vec3(1.0, 0.88, 0.30), vec3(1.0));
    float place = clamp(t, 0.0, 1.0) * 6.0;
    int k = min(int(place), 5);
    return mix(STOPS[k], STOPS[k + 1], place - float(k));
}

// A colour for a whole number: neighbours differ clearly, 0 is nearly black.
vec3 id_color(uint id) {
    if (id == 0u) return vec3(0.04);
    float hue = float((id * 2654435769u) >> 8u) * (1.0 / 16777216.0);   // id over the golden ratio, of any size
    vec3 wheel = clamp(abs(fract(hue + vec3(0.0, 2.0 / 3.0, 1.0 / 3.0)) * 6.0 - 3.0) - 1.0, 0.0, 1.0);
    return mix(vec3(1.0), wheel, 0.72) * ((id & 1u) != 0u ? 0.95 : 0.72);
}

vec3 log_distance(float distance_m) {
    // r_range is that of log2 of the distance along forward.
    float far = log2(max(distance_m, 1e-6));
    vec3 color = heat(0.12 + 0.85 * (far - r_range.x) / max(r_range.y - r_range.x, 1e-3));
    // A fine dark line at each doubling.
    float line = abs(fract(far + 0.5) - 0.5), width = max(fwidth(far), 1e-6);
    return color * mix(0.55, 1.0, smoothstep(0.5, 1.5, line / width));
}

void main() {
    vec4 value = source_at(v_uv);
    vec3 color = value.rgb;
    float span = max(r_range.y - r_range.x, 1e-30);
#if MODE == MODE_RANGE
    color = (value.rgb - r_range.x) / span;
#elif MODE == MODE_HEAT
    color = heat((value.r - r_range.x) / span);
#elif MODE == MODE_SIGNED
    color = value.rgb * 0.5 + 0.5;
#elif MODE == MODE_NORMAL
    bool seen = texelFetch(u_depth, ivec2(gl_FragCoord.xy), 0).r > 0.0;
    color = seen ? oct_decode(value.rg) * 0.5 + 0.5 : vec3(0.0);
#elif MODE == MODE_DEPTH
    color = value.r > 0.0 ? log_distance(forward_distance(value.r)) : vec3(0.0);
#elif MODE == MODE_DISTANCE
    color = value.r > 0.0 ? log_distance(length(position_from_depth(v_ndc, value.r))) : vec3(0.0);
#elif MODE == MODE_IDS
    color = id_color(number_at(v_uv));
#elif MODE == MODE_SURFACE
    const vec3 SURFACES[4] = vec3[4](vec3(0.04), vec3(0.35, 0.62, 0.25), vec3(0.15, 0.40, 0.80),
        vec3(0.85, 0.25, 0.20));
    color = SURFACES[min(uint(value.r), 3u)];
#elif MODE == MODE_LOD
    bool seen = texelFetch(u_depth, ivec2(gl_FragCoord.xy), 0).r > 0.0;
    color = seen ? id_color(uint(log2(spacing_decode(value.a)) + 8.5) + 1u) : vec3(0.0);
#elif MODE == MODE_HDR
    float bright = luminance_of_radiance(value.rgb * frame.radiance_per_hdr);
    color = bright > 0.0 ? heat((log2(bright) - r_range.x + log2(frame.hdr_per_radiance)) / span) : vec3(0.0);
#elif MODE == MODE_PX
    color = heat((log2(max(value.r, 1e-4)) * 0.30103 + 2.0) / 3.0);
#elif MODE == MODE_SLOPE
    float depth = texelFetch(u_depth, ivec2(gl_FragCoord.xy), 0).r;
    vec3 up = up_at(position_from_depth(v_ndc, max(depth, 1e-20)));
    float slope = atan(length(cross(up, value.xyz)), dot(up, value.xyz));
    color = depth > 0.0 ? heat(slope * 0.63661977) : vec3(0.3);
#elif MODE == MODE_SHARE
    color = vec3(value.r);
#elif MODE == MODE_ALBEDO
    color = srgb_encode(value.rgb);
#elif MODE == MODE_MATERIAL
    color = id_color(uint(value.a));
#elif MODE == MODE_HISTORY
    float gathered = log2(float(int(value.a) & PLACE_FRAMES)) / 4.0;
    color = gathered < 0.5 ? mix(vec3(0.80, 0.12, 0.10), vec3(0.95, 0.80, 0.10), max(gathered, 0.0) * 2.0)
                           : mix(vec3(0.95, 0.80, 0.10), vec3(0.10, 0.55, 0.20), min(gathered, 1.0) * 2.0 - 1.0);
#endif
    bool good = !any(isnan(value)) && !any(isinf(value));
    o_color = vec4(good ? clamp(color, 0.0, 1.0) : vec3(1.0, 0.0, 1.0), 1.0);
}
