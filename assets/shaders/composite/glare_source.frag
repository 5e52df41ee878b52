// The light that glares: the exposed scene.
#include "generated/bindings.glsl"
#include "common/color.glsl"
#include "composite/exposure.glsl"

layout(binding = 0) uniform sampler2D u_scene;  // radiance, a quarter of the view's size
layout(std430, binding = EXPOSURE_BUFFER) readonly buffer ExposureIn { Exposure exposure; };
layout(location = 0) out vec4 o_light;

void main() {
    vec3 radiance = texelFetch(u_scene, ivec2(gl_FragCoord.xy), 0).rgb;
    o_light = vec4(min(display_light(radiance) / exposure.saturated, vec3(1e9)), 1.0);
}
