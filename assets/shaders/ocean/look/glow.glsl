// Liquids that shine by themselves, under a crust that breaks into plates.
#include "ocean/look/pixel.glsl"

// Radiance, and in w the share of the surface that crust covers.
vec4 liquid_glow(SeaPixel p) {
    float crust = ocean.crust_share, covered = crust;
    // Plates of 64 m with smaller ones between them, which drift; where a pixel is larger they are a mean.
    float octave = max(log2(max(8.0 * p.footprint_m / 64.0, 1.0)), 0.0);
    int turns = crust > 0.0 && octave < 12.0 ? 3 : 0, k = 10 + int(octave);
    float value = 0.0, total = 0.0, squares = 0.0;
    int i = 0;
    if (turns > 0) do {
        float weight = i == 0 ? 1.0 - fract(octave) : i == 1 ? 0.8 : 0.6;
        value -= weight * abs(sea_noise(p.D, max(k - i, 1)));
        total += weight;
        squares += weight * weight;
    } while (++i < turns);
    if (turns > 0) {
        // Cracks where noise passes zero, as wide as the share wants them: the magnitude's mean is 0.57, its deviation
        // 0.42.
        float c = clamp(crust, 1e-3, 0.999), deviation = 0.42 * sqrt(squares);
        float limit = -0.57 * total + deviation * 0.59 * log(c / (1.0 - c));
        covered = smoothstep(limit + 0.3 * deviation, limit - 0.3 * deviation, value);
        covered = mix(covered, crust, clamp(octave - 8.0, 0.0, 1.0));
    }
    return vec4(ocean.glow_radiance * (1.0 - 0.97 * covered), covered);
}
