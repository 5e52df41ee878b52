// A planet as another one's camera sees it: its light, and the share that it hides of what is behind. Where its ground
// or sea is that is all; beside them what its air takes.
#include "common/camera.glsl"
#include "contract/air.glsl"

layout(binding = 0) uniform sampler2D u_scene;
layout(binding = 1) uniform sampler2D u_depth;
layout(location = 0) out vec4 o_picture;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 through = air_to_space(vec3(0.0), normalize(view_ray(ndc_of_pixel(gl_FragCoord.xy))));
    float hidden = texelFetch(u_depth, pixel, 0).r > 0.0 ? 1.0 : 1.0 - dot(through, vec3(1.0 / 3.0));
    o_picture = vec4(texelFetch(u_scene, pixel, 0).rgb * frame.radiance_per_hdr, clamp(hidden, 0.0, 1.0));
}
