// 3 x 3 bilinear look-ups with the weights 1 2 1. Wider than interpolation needs, so that a point becomes a round spot and
// not the shape of its texel.
vec3 tent_at(sampler2D from, vec2 uv) {
    vec2 texel = 1.0 / vec2(textureSize(from, 0));
    vec3 total = vec3(0.0);
    for (int k = 0; k < 9; k++) {
        vec2 side = vec2(k % 3, k / 3) - 1.0;
        float weight = (side.x == 0.0 ? 2.0 : 1.0) * (side.y == 0.0 ? 2.0 : 1.0);
        total += weight * textureLod(from, uv + side * texel, 0.0).rgb;
    }
    return total / 16.0;
}
