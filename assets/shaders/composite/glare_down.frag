// One step down in size through a Gaussian of two source texels, as 6 x 6 bilinear look-ups at the centres of gravity of
// pairs of texels. Narrower ones leave so few texels of a small sun that its halo shows their square shape.
layout(binding = 0) uniform sampler2D u_from;
in vec2 v_uv;
layout(location = 0) out vec4 o_light;

void main() {
    const float PLACES[3] = float[3](0.9379, 2.8204, 4.7227);
    const float WEIGHTS[3] = float[3](0.34474, 0.13479, 0.02047);  // their sum is 1/2: there are two sides
    vec2 texel = 1.0 / vec2(textureSize(u_from, 0));
    vec3 total = vec3(0.0);
    for (int k = 0; k < 36; k++) {
        ivec2 tap = ivec2(k % 6, k / 6);
        vec2 side = vec2(tap.x < 3 ? -1.0 : 1.0, tap.y < 3 ? -1.0 : 1.0);
        tap %= 3;
        total += WEIGHTS[tap.x] * WEIGHTS[tap.y]
            * textureLod(u_from, v_uv + side * texel * vec2(PLACES[tap.x], PLACES[tap.y]), 0.0).rgb;
    }
    o_light = vec4(total, 1.0);
}
