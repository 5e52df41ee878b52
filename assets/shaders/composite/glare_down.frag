// One step down in size: 6 x 6 texels with the weights 1 5 10 10 5 1, as nine bilinear look-ups. Nearly a Gaussian: with
// fewer texels the halo of a sun is a square.
layout(binding = 0) uniform sampler2D u_from;
in vec2 v_uv;
layout(location = 0) out vec4 o_light;

void main() {
    vec2 texel = (5.0 / 3.0) / vec2(textureSize(u_from, 0));
    vec3 total = vec3(0.0);
    for (int k = 0; k < 9; k++) {
        vec2 side = vec2(k % 3, k / 3) - 1.0;
        float weight = (side.x == 0.0 ? 20.0 : 6.0) * (side.y == 0.0 ? 20.0 : 6.0);
        total += weight * textureLod(u_from, v_uv + side * texel, 0.0).rgb;
    }
    o_light = vec4(total / 1024.0, 1.0);
}
