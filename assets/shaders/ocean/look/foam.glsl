// Foam: how much of the water it covers, and its pattern.
#include "common/camera.glsl"
#include "ocean/look/noise.glsl"

const float FOAM_COARSE_M = 1.0, FOAM_FINE_M = 0.125;

// 0..1 in the pattern of foam that covers a share of the water, 1 where it lies: threads around bubbles and patches. The mean
// over the water is about the share, and that is what is left where a pixel is too large for the pattern.
float foam_pattern(vec3 D, float footprint_m, float share) {
    float coarse = clamp(1.5 - 3.0 * footprint_m / FOAM_COARSE_M, 0.0, 1.0);
    float fine = clamp(1.5 - 3.0 * footprint_m / FOAM_FINE_M, 0.0, 1.0);
    float value = 0.0;
    int turns = share > 0.004 && coarse > 0.0 ? (fine > 0.0 ? 3 : 1) : 0;
    for (int i = 0; i < turns; ++i) {
        float n = sea_noise(D, i == 0 ? 4 : i == 1 ? 2 : 1);
        value += i == 0 ? 0.7 * coarse * n : (i == 1 ? 0.85 : 0.5) * fine * (0.78 - abs(n)) * 1.6;
    }
    // The share's quantile of a normal distribution, nearly.
    float c = clamp(share, 1e-3, 0.999), deviation = max(0.7 * coarse + 0.3 * fine, 1e-3);
    float limit = -log(c / (1.0 - c)) * 0.59 * deviation;
    float soft = mix(4.0, 0.35, coarse) * deviation;
    float cover = smoothstep(limit - soft, limit + soft, value);
    return turns == 0 ? share : mix(share, cover, coarse);
}
