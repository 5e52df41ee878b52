#include "generated/frame.glsl"
#include "common/octahedral.glsl"
#include "common/sea_depth.glsl"
#include "common/surfaces.glsl"

in vec3 v_normal;
in float v_shallow;
flat in int v_level;
layout(location = 0) out vec2 o_normal;
layout(location = 1) out vec4 o_attributes;
layout(location = 2) out uint o_surface;

void main() {
    o_normal = oct_encode(normalize(v_normal));
    o_attributes = vec4(sea_depth_encode(v_shallow), 0.0, float(v_level) / 32.0);
    o_surface = SURFACE_SEA;
#ifdef PF_FRAG_DEPTH
    gl_FragDepth = frame.camera_offset.w * gl_FragCoord.w;
#endif
}
