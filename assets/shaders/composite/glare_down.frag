// One step down in size through a Gaussian of 1.6 source texels, as 4 x 4 bilinear look-ups at the centres of gravity
// of pairs of texels. Narrower ones leave so few texels of a small sun that its halo shows their square shape.
layout(binding = 0) uniform sampler2D u_from;
in vec2 v_uv;
layout(location = 0) out vec4 o_light;

void main() {
    const float PLACES[4] = float[4](-2.736516, -0.903567, 0.903567, 2.736516);
    const float WEIGHTS[4] = float[4](0.097425, 0.402575, 0.402575, 0.097425);
    vec2 texel = 1.0 / vec2(textureSize(u_from, 0));
    vec3 total = vec3(0.0);
    for (int k = 0; k < 16; k++) {
        ivec2 tap = ivec2(k & 3, k >> 2);
        vec2 place = vec2(PLACES[tap.x], PLACES[tap.y]) * texel;
        total += WEIGHTS[tap.x] * WEIGHTS[tap.y] * textureLod(u_from, v_uv + place, 0.0).rgb;
    }
    o_light = vec4(total, 1.0);
}
