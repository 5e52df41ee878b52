// The depth of water in two channels of gbuffer.attributes: depth / (depth + 16 m) in 16 bits.
vec2 sea_depth_encode(float shallow) {
    float scaled = clamp(shallow, 0.0, 1.0) * 65535.0;
    float high = floor(scaled / 256.0);
    return vec2(high / 255.0, (scaled - high * 256.0) / 255.0);
}
