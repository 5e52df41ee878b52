// 3 x 3 bilinear look-ups with the weights 1 2 1, as the 2 x 2 that see the same 4 x 4 texels. Wider than interpolation
// needs, so that a point becomes a round spot and not the shape of its texel.
vec3 tent_at(sampler2D from, vec2 uv) {
    vec2 size = vec2(textureSize(from, 0)), place = uv * size - 0.5, f = fract(place);
    // Texels along an axis weigh 1 - f, 2 - f, 1 + f and f.
    vec2 first = 3.0 - 2.0 * f, second = 1.0 + 2.0 * f, base = place - f - 0.5, texel = 1.0 / size;
    vec2 low = (base + (2.0 - f) / first) * texel, high = (base + 2.0 + f / second) * texel;
    return (first.y * (first.x * textureLod(from, low, 0.0).rgb
        + second.x * textureLod(from, vec2(high.x, low.y), 0.0).rgb)
        + second.y * (first.x * textureLod(from, vec2(low.x, high.y), 0.0).rgb
            + second.x * textureLod(from, high, 0.0).rgb)) / 16.0;
}
