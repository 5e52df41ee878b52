// The waves of the sea as seen from the anchor; systems/ocean/wave_block.py packs them. Longest first, in two lists:
// waves whose origin and antipode are far from here, which a short series places exactly enough, and those that need
// the whole formula.
#include "generated/bindings.glsl"
const int WAVES_MOST = 1000;
const int WAVE_BINS = 64;

layout(std140, binding = WAVE_BLOCK) uniform WaveBlock {
    vec4 wave_east;      // first tangent at the anchor; w: radius of the calm sea, m
    vec4 wave_north;     // second tangent; w: the anchor's foot to the calm sea, as a ratio of radii
    // waves of the first list, waves of both, the farthest that anything is moved sideways in m, unused
    vec4 wave_counts;
    vec4 wave_eye;       // the proxy from the anchor, m; w: angle between vertices
    // smallest distance of vertices in m, footprint of a pixel in pixels, sine of the latitude of ice (2: none), unused
    vec4 wave_mesh;
    // by wave number: waves that are longer (first list + 1024 * second), slope variance of the rest
    vec4 wave_bins[WAVE_BINS];
    vec4 wave_data[3 * WAVES_MOST];
    // first list:  heading away from the origin (2), phase at the anchor in cycles, cycles per m
    //              A, Q A in m, half the cotangent of the angle from the origin / radius, (2 a^2 + 1/6) / radius^2
    //              (k h1 / pi)^2, 2 k^2 h1 h2 / pi^2, (k h2 / pi)^2, k
    // second list: the same; A, Q A, cosine and sine of the angle from the origin; edges of the fade, unused, k
};

// How many waves may be longer than 2 pi / k (first list + 1024 * second), and the slope variance of the others.
vec4 wave_bin(float k) {
    return wave_bins[clamp(int(floor(4.0 * (log2(k) + 12.0))), 0, WAVE_BINS - 1)];
}

// The two numbers of waves in a bin.
ivec2 wave_count(vec4 bin) {
    float near = floor(bin.x * (1.0 / 1024.0));
    return ivec2(int(bin.x - 1024.0 * near), int(near));
}
