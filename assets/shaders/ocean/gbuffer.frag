#include "generated/frame.glsl"
#include "common/octahedral.glsl"
#include "common/sea_depth.glsl"
#include "common/spacing_code.glsl"
#include "common/surfaces.glsl"

in vec3 v_normal;
in float v_shallow;
flat in float v_spacing;
layout(location = 0) out vec2 o_normal;
layout(location = 1) out vec4 o_attributes;
layout(location = 2) out uint o_surface;
#ifdef SEA_MOVES
in vec2 v_moved;
layout(location = 3) out vec2 o_moved;
#endif
#ifdef SEA_PAPER
layout(location = 3) out vec4 o_rough;   // as ocean/surface.comp makes it
uniform float u_variance;
#endif

void main() {
    o_normal = oct_encode(normalize(v_normal));
    o_attributes = vec4(sea_depth_encode(v_shallow), 0.0, spacing_encode(v_spacing));
    o_surface = SURFACE_SEA;
#ifdef SEA_MOVES
    o_moved = v_moved;
#endif
#ifdef SEA_PAPER
    o_rough = vec4(0.5 * u_variance, 0.5 * u_variance, 0.0, 1.0);
#endif
#ifdef PF_FRAG_DEPTH
    gl_FragDepth = frame.near_m * gl_FragCoord.w;
#endif
}
