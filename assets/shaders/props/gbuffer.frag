#include "generated/frame.glsl"
#include "common/octahedral.glsl"
#include "common/surfaces.glsl"

in vec3 v_normal;
flat in vec4 v_color;
in vec4 v_back;
layout(location = 0) out vec2 o_normal;
layout(location = 1) out vec4 o_attributes;   // square root of the reflectance, roughness
layout(location = 2) out uint o_surface;
layout(location = 3) out vec4 o_motion;

void main() {
    o_normal = oct_encode(normalize(v_normal));
    o_attributes = vec4(sqrt(v_color.rgb), v_color.a);
    o_surface = SURFACE_PROPS;
    o_motion = v_back;
#ifdef PF_FRAG_DEPTH
    gl_FragDepth = frame.near_m * gl_FragCoord.w;
#endif
}
