// What one prop leaves of the sun's light (red) and of the sky's (green); multiplied over all props.
#include "common/camera.glsl"
#include "common/octahedral.glsl"
#include "common/surfaces.glsl"
#include "props/instance.glsl"
#include "props/shadow.glsl"

layout(std430, binding = 0) readonly buffer OccluderBuffer { PropOccluder occluders[]; };
layout(binding = 0) uniform sampler2D u_depth;
layout(binding = 1) uniform sampler2D u_normal;
layout(binding = 2) uniform usampler2D u_surface;
flat in int v_prop;
layout(location = 0) out vec2 o_left;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(u_depth, pixel, 0).r;
    vec3 point = position_from_depth(ndc_of_pixel(gl_FragCoord.xy), max(depth, 1e-30));
    PropOccluder prop = occluders[v_prop];
    o_left = vec2(1.0);
    float own = texelFetch(u_surface, pixel, 0).r == SURFACE_PROPS ? 1.04 : 0.0;
#if AROUND
    if (depth > 0.0) o_left.g = prop_ambient(prop, point, oct_decode(texelFetch(u_normal, pixel, 0).rg), own);
#else
    if (depth > 0.0) o_left.r = prop_sun(prop, point, own);
#endif
#ifdef PF_FRAG_DEPTH
    gl_FragDepth = 0.0;
#endif
}
