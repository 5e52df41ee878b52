// One step up in size: a smooth spline from four bilinear look-ups, half a texel to four sides.
layout(binding = 0) uniform sampler2D u_from;
layout(location = 0) uniform float u_share;  // of this octave and all blunter ones
in vec2 v_uv;
layout(location = 0) out vec4 o_light;

void main() {
    vec2 texel = 0.5 / vec2(textureSize(u_from, 0));
    vec3 total = vec3(0.0);
    for (int k = 0; k < 4; k++) {
        vec2 side = vec2((k & 1) != 0 ? 1.0 : -1.0, (k & 2) != 0 ? 1.0 : -1.0);
        total += textureLod(u_from, v_uv + side * texel, 0.0).rgb;
    }
    o_light = vec4(total * (0.25 * u_share), 0.0);
}
