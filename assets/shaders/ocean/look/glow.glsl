// Liquids that shine by themselves, under a crust that breaks into plates.
#include "ocean/look/pixel.glsl"

// Radiance, and in w the share of the surface that crust covers.
vec4 liquid_glow(SeaPixel p) {
    float crust = ocean.glow.w, covered = crust;
    // Plates of 64 m with smaller ones between them, which drift; where a pixel is larger they are a mean.
    float octave = max(log2(max(8.0 * p.footprint_m / 64.0, 1.0)), 0.0);
    int turns = crust > 0.0 && octave < 12.0 ? 3 : 0, k = 10 + int(octave);
    float value = 0.0, total = 0.0;
    for (int i = 0; i < turns; ++i) {
        float weight = i == 0 ? 1.0 - fract(octave) : i == 1 ? 0.8 : 0.6;
        value += weight * (1.1 - 2.2 * abs(sea_noise(p.D, max(k - i, 1))));
        total += weight * weight;
    }
    if (turns > 0) {
        // Cracks where noise passes zero; their width follows from the share.
        float limit = mix(2.2, -1.6, crust) * sqrt(total) * 0.6;
        covered = smoothstep(limit + 0.35, limit - 0.35, value - 0.3);
        covered = mix(covered, crust, clamp(octave - 8.0, 0.0, 1.0));
    }
    return vec4(ocean.glow.rgb * (1.0 - 0.97 * covered), covered);
}
