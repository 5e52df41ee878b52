// The distance of the vertices that drew a pixel, in the eight bits of gbuffer.attributes.w: its logarithm in eighths
// of an octave, from 2^-8 m to 2^23.875 m. Whoever shades takes up below this spacing what the vertices had to leave
// out.
float spacing_encode(float spacing_m) {
    return clamp((log2(spacing_m) + 8.0) * (8.0 / 255.0), 0.0, 1.0);
}

float spacing_decode(float code) {
    return exp2(code * (255.0 / 8.0) - 8.0);
}
