// Anti-aliasing of a still camera: the mean of samples at many places in each pixel.
#include "generated/bindings.glsl"
#include "common/camera.glsl"
#include "composite/exposure.glsl"
#include "composite/resolved.glsl"

layout(binding = 0) uniform sampler2D u_scene;
layout(binding = 1) uniform sampler2D u_depth;
layout(binding = 2) uniform usampler2D u_surface;
layout(binding = 3) uniform sampler2D u_before;
layout(std430, binding = EXPOSURE_BUFFER) readonly buffer ExposureIn { Exposure exposure; };
layout(std430, binding = EXPOSURE_BEFORE_BUFFER) readonly buffer ExposureBefore { Exposure exposure_before; };
layout(location = 0) uniform float u_weight;   // of this frame
layout(location = 0) out vec4 o_resolved;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 now = press(exposed_light(texelFetch(u_scene, pixel, 0).rgb * frame.radiance_per_hdr, exposure.saturated));
    float per_m = texelFetch(u_depth, pixel, 0).r / frame.near_m;
    float place = place_code(place_distance(per_m), texelFetch(u_surface, pixel, 0).r, PLACE_FRAMES);
    vec4 before = texelFetch(u_before, pixel, 0);
    float ratio = exposure_before.saturated / exposure.saturated;
    // Undefined in the first frame: not a number times nothing would be none either.
    vec3 light = press_again(before.rgb, ratio);
    light = u_weight < 1.0 ? mix(light, now, u_weight) : now;
    o_resolved = vec4(light, u_weight > 0.0 ? place : before.a);
}
