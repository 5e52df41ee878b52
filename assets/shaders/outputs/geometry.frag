// The G-buffer in metres, for programs.
#include "generated/frame.glsl"
#include "common/camera.glsl"
#include "common/octahedral.glsl"

layout(binding = 0) uniform sampler2D u_depth;
layout(binding = 1) uniform sampler2D u_normal;
layout(binding = 2) uniform usampler2D u_surface;
in vec2 v_ndc;
layout(location = 0) out vec4 o_position;
layout(location = 1) out vec4 o_normal;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(u_depth, pixel, 0).r;
    uint surface = texelFetch(u_surface, pixel, 0).r;
    vec3 position = view_ray(v_ndc) * (frame.near_m / depth);
    bool hit = depth > 0.0;
    float nan = uintBitsToFloat(0x7fc00000u), infinite = uintBitsToFloat(0x7f800000u);
    o_position = hit ? vec4(position, length(position)) : vec4(nan, nan, nan, infinite);
    o_normal = hit ? vec4(oct_decode(texelFetch(u_normal, pixel, 0).rg), float(surface)) : vec4(0.0);
}
