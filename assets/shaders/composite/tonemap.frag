// Scene radiance, or what anti-aliasing has made of it, to the picture: glare, exposure, tone map, dither.
// Defines: TONE_MAP, DITHER, GLARE, RESOLVED (0, 1).
#include "generated/bindings.glsl"
#include "generated/frame.glsl"
#include "common/tonemap.glsl"
#include "common/dither.glsl"
#include "composite/exposure.glsl"
#if RESOLVED
#include "composite/resolved.glsl"
#endif

layout(binding = 0) uniform sampler2D u_scene;
layout(std430, binding = EXPOSURE_BUFFER) readonly buffer ExposureIn { Exposure exposure; };
#if GLARE
layout(binding = 1) uniform sampler2D u_glare;
// shares of the light: that goes into the finest octave of glare, that is left
layout(location = 0) uniform float u_glare_share;
layout(location = 2) uniform float u_kept_share;
// the glare is that of this frame's samples, beside the pixels' centres
layout(location = 1) uniform vec2 u_glare_from;
#endif
in vec2 v_uv;
layout(location = 0) out vec4 o_color;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
#if RESOLVED
    vec3 exposed = unpress(max(texelFetch(u_scene, pixel, 0).rgb, 0.0));
#else
    vec3 radiance = textureLod(u_scene, v_uv, 0.0).rgb * frame.radiance_per_hdr;   // the nearest texel
    // A comparison that fails for NaN as well: it becomes black instead of spreading.
    vec3 exposed = display_light(mix(vec3(0.0), radiance, greaterThan(radiance, vec3(0.0))))
        * (1.0 / exposure.saturated);
    exposed = min(exposed, vec3(1e6));
#endif
#if GLARE
    exposed = exposed * u_kept_share + textureLod(u_glare, v_uv + u_glare_from, 0.0).rgb * u_glare_share;
#endif
    vec3 color = tone_map(exposed);
#if DITHER
    color = dithered(color, pixel);
#endif
    o_color = vec4(color, 1.0);
}
