// The depth of water in two channels of gbuffer.attributes: depth / (depth + 16 m) in 16 bits.
vec2 sea_depth_encode(float shallow) {
    float scaled = clamp(shallow, 0.0, 1.0) * 65535.0;
    float high = floor(scaled / 256.0);
    return vec2(high / 255.0, (scaled - high * 256.0) / 255.0);
}

// Metres of depth / (depth + 16 m).
float sea_depth_m(float shallow) {
    return 16.0 * shallow / max(1.0 - shallow, 1e-4);
}

// The same from the two channels.
float sea_depth_decode(vec2 channels) {
    vec2 bytes = channels * 255.0;
    return sea_depth_m((bytes.x * 256.0 + bytes.y) / 65535.0);
}
