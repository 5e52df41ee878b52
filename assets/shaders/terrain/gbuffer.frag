#include "generated/frame.glsl"
#include "common/octahedral.glsl"
#include "common/surfaces.glsl"

in vec3 v_normal;
in vec4 v_attributes;
layout(location = 0) out vec2 o_normal;
layout(location = 1) out vec4 o_attributes;
layout(location = 2) out uint o_surface;

void main() {
    o_normal = oct_encode(normalize(v_normal));
    o_attributes = v_attributes;
    o_surface = SURFACE_TERRAIN;
#ifdef PF_FRAG_DEPTH
    gl_FragDepth = frame.near_m * gl_FragCoord.w;
#endif
}
