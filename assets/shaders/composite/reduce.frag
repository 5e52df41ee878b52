// Mean of 4 x 4 pixels of the scene, scale taken off: what metering and glare look at.
#include "generated/frame.glsl"

layout(binding = 0) uniform sampler2D u_scene;
layout(location = 0) out vec4 o_radiance;

void main() {
    ivec2 corner = ivec2(gl_FragCoord.xy) * 4;
    vec2 texel = 1.0 / vec2(textureSize(u_scene, 0));   // beyond the last row and column as these are
    vec3 total = vec3(0.0);
    for (int k = 0; k < 16; k++) {
        vec3 value = textureLod(u_scene, (vec2(corner + ivec2(k & 3, k >> 2)) + 0.5) * texel, 0.0).rgb;
        // Not a number fails every comparison: one bad pixel must not spoil the exposure and glare of the whole
        // picture.
        for (int c = 0; c < 3; c++) total[c] += value[c] > 0.0 && value[c] < 1e30 ? value[c] : 0.0;
    }
    o_radiance = vec4(total * (frame.radiance_per_hdr / 16.0), 1.0);
}
