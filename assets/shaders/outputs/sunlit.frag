// Share of the sun's disc that a pixel's surface sees, for programs: 0 where it faces away, or where ground, clouds,
// trees or props are in the way.
#include "generated/bindings.glsl"
#include "common/camera.glsl"
#include "common/octahedral.glsl"
#include "common/surfaces.glsl"
#include "contract/sun_visibility.glsl"
#include "contract/cover_light.glsl"

layout(binding = DEPTH_UNIT) uniform sampler2D u_depth;
layout(binding = NORMAL_UNIT) uniform sampler2D u_normal;
layout(binding = SURFACE_UNIT) uniform usampler2D u_surface;
#ifdef PROP_SHADOWS
layout(binding = 4) uniform sampler2D u_shadow;
#endif
in vec2 v_ndc;
layout(location = 0) out float o_sunlit;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(u_depth, pixel, 0).r;
    o_sunlit = 0.0;
    if (depth <= 0.0) return;
    uint surface = texelFetch(u_surface, pixel, 0).r;
    vec3 point = position_from_depth(v_ndc, depth), normal = oct_decode(texelFetch(u_normal, pixel, 0).rg);
    // The disc sinks behind the surface's own plane.
    float facing = smoothstep(-1.0, 1.0, dot(normal, frame.sun_direction) / max(frame.sun_radius_rad, 1e-4));
    // Biases of cover/shade.comp, terrain/forest.glsl and ocean/shade.comp.
    float bias_m = surface == SURFACE_COVER ? 0.8 : surface == SURFACE_SEA ? 0.0 : 0.3;
    o_sunlit = facing * sun_visibility(point) * cover_light(point, bias_m);
#ifdef PROP_SHADOWS
    o_sunlit *= texelFetch(u_shadow, pixel, 0).r;
#endif
}
