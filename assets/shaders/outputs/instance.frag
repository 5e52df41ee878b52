// Numbers of things that stand on their own, drawn a second time: where the G-buffer shows this very thing.
#include "generated/frame.glsl"
#include "common/surfaces.glsl"

layout(binding = 0) uniform sampler2D u_depth;
layout(binding = 1) uniform usampler2D u_surface;
flat in uint v_instance;
layout(location = 0) out uint o_instance;

const float SAME_DEPTH = 1e-5;   // apart, as a share: 1 mm at 100 m

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float shown = texelFetch(u_depth, pixel, 0).r, own = frame.near_m * gl_FragCoord.w;
    if (texelFetch(u_surface, pixel, 0).r != INSTANCE_SURFACE || abs(own - shown) > SAME_DEPTH * shown) discard;
    o_instance = v_instance;
}
