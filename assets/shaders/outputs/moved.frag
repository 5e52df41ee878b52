// Where the surface that a pixel shows was a frame ago, from the camera as it is now, planet axes. Ground and water
// stand still, props may say where they come from.
#include "generated/frame.glsl"
#include "common/camera.glsl"
#include "common/surfaces.glsl"

layout(binding = 0) uniform sampler2D u_depth;
layout(binding = 1) uniform usampler2D u_surface;
#ifdef MOTION
layout(binding = 2) uniform sampler2D u_motion;
#endif
in vec2 v_ndc;
layout(location = 0) out vec4 o_moved;   // w: 1 where it was there; 0 where it was not, or nothing is

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(u_depth, pixel, 0).r;
    o_moved = depth > 0.0 ? vec4(view_ray(v_ndc) * (frame.near_m / depth), 1.0) : vec4(0.0);
#ifdef MOTION
    if (texelFetch(u_surface, pixel, 0).r == SURFACE_PROPS) {
        vec4 back = texelFetch(u_motion, pixel, 0);
        o_moved = vec4(o_moved.xyz + back.xyz, back.w);
    }
#endif
}
