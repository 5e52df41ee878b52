// A texel of a texture that is filtered by nearest. Software GPUs look it up by coordinates sooner than by texelFetch,
// whose every lane asks whether it lies outside; what is found there is undefined here.

vec4 texel_at(sampler2D from, ivec2 texel) {
    return textureLod(from, (vec2(texel) + 0.5) * (1.0 / vec2(textureSize(from, 0))), 0.0);
}

uvec4 texel_at(usampler2D from, ivec2 texel) {
    return textureLod(from, (vec2(texel) + 0.5) * (1.0 / vec2(textureSize(from, 0))), 0.0);
}
