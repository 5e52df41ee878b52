// Other planets, dimmed and reddened by the air before them. Drawn where depth is 0, over what that air scatters.
#include "common/camera.glsl"
#include "contract/air.glsl"

layout(binding = 0) uniform sampler2D u_planets;  // engine/frame/backdrop.py
layout(location = 0) uniform float u_limit;       // largest value that the target can hold
layout(location = 0) out vec4 o_radiance;

void main() {
    vec3 light = texelFetch(u_planets, ivec2(gl_FragCoord.xy), 0).rgb;
    light *= air_to_space(vec3(0.0), normalize(view_ray(ndc_of_pixel(gl_FragCoord.xy))));
    o_radiance = vec4(min(light * frame.hdr_per_radiance, vec3(u_limit)), 0.0);
#ifdef PF_FRAG_DEPTH
    gl_FragDepth = 0.0;
#endif
}
