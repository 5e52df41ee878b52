// All octaves of glare together, at a quarter of the view's size: the finest, blurred here by 1.3 texels (5 x 5
// bilinear look-ups of 9 x 9 texels), and the sum of the blunter ones.
#include "composite/tent.glsl"

layout(binding = 0) uniform sampler2D u_source;
layout(binding = 1) uniform sampler2D u_blunter;
layout(location = 0) uniform float u_share;  // of the blunter ones against the finest
in vec2 v_uv;
layout(location = 0) out vec4 o_light;

void main() {
    const float PLACES[5] = float[5](-3.11195, -1.29161, 0.0, 1.29161, 3.11195);
    const float WEIGHTS[5] = float[5](0.024115, 0.322385, 0.306999, 0.322385, 0.024115);
    vec2 texel = 1.0 / vec2(textureSize(u_source, 0));
    vec3 total = vec3(0.0);
    for (int k = 0; k < 25; k++) {
        ivec2 tap = ivec2(k % 5, k / 5);
        vec2 place = vec2(PLACES[tap.x], PLACES[tap.y]) * texel;
        total += WEIGHTS[tap.x] * WEIGHTS[tap.y] * textureLod(u_source, v_uv + place, 0.0).rgb;
    }
    o_light = vec4(total + u_share * tent_at(u_blunter, v_uv), 1.0);
}
