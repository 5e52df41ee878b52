// Foam: how much of the water it covers, and its pattern.
#include "common/camera.glsl"
#include "ocean/look/noise.glsl"
#include "ocean/look/slopes.glsl"

// From half a metre on a pixel shows no pattern (systems/ocean/shading.py).
const float FOAM_COARSE_M = 1.0, FOAM_FINE_M = 0.125;
// Width of whitecaps, m, and the octave of that wavelength.
const float WHITECAP_M = 4.0;
const int WHITECAP_OCTAVE = 6;

// Share of the water that breaking crests cover: where the surface is squeezed (1 - Jacobian) beyond a limit that
// leaves as much of it as Monahan and O'Muircheartaigh (1980) saw under that wind. What a pixel does not show of the
// waves counts as a Gaussian around what it does. rough: variance of the slopes that the pixel does not show, of both
// axes.
float crest_foam(float fold, float rough) {
    float deviation = ocean.crests.deviation;
    float hidden = clamp((rough - ocean.crests.variance_beyond) / max(ocean.crests.slope_variance, 1e-9), 0.0, 1.0);
    float soft = max(deviation * sqrt(hidden), 0.12 * deviation);
    float over = (1.0 - fold - ocean.crests.squeeze) / max(soft, 1e-6);
    // Where a crest has passed, threads stay a little longer.
    float left = over + 0.8 * deviation / max(soft, 1e-6) * (1.0 - hidden);
    return deviation > 0.0 ? max(slopes_below(clamp(over, -6.0, 6.0)),
        0.3 * (1.0 - hidden) * slopes_below(clamp(left, -6.0, 6.0))) : 0.0;
}

// Noise of variance 1 that is drawn out along crests. ragged: 0..1, of its third octave.
float whitecap_noise(vec3 D, float ragged) {
    vec3 along = ocean.whitecaps.heading * dot(D, ocean.whitecaps.heading);
    vec3 place = along + (D - along) * ocean.whitecaps.per_length;
    float value = 0.0, share = 1.22;
    int i = 0, turns = ragged > 0.0 ? 3 : 2;
    do {
        ivec3 cell;
        vec3 fraction;
        float frequency;
        nested_place(ocean.whitecaps.anchor.cell, ocean.whitecaps.anchor.fraction, place, WHITECAP_OCTAVE - i, cell,
            fraction, frequency);
        value += share * gradient_noise_value(cell, fraction) / NESTED_RMS;
        share = i == 0 ? 0.72 : 0.45 * ragged;
    } while (++i < turns);
    return value;
}

// A sea breaks here and there along its crests, in patches some metres wide, and wholly there: noise gathers the share
// that crests alone would spread thinly over all of them. Its mean stays, and is what is left in larger pixels.
float whitecaps(vec3 D, float footprint_m, float share) {
    // Near the camera the waves themselves show where they break, and foam_pattern its threads.
    float size = footprint_m / WHITECAP_M, seen = clamp(1.5 - size, 0.0, 1.0) * clamp(10.0 * size - 0.4, 0.0, 1.0);
    if (share < 5e-4 || share > 0.5 || seen <= 0.0) return share;
    // The share's quantile, of four million values: within 0.1 from 5e-4 to 0.1.
    float limit = sqrt(-2.0 * log(share)) - 0.76;
    float soft = 0.6;   // thin at their edges: there foam_pattern shows threads
    float value = whitecap_noise(D, clamp(3.0 - 10.0 * size, 0.0, 1.0));
    return mix(share, 0.9 * smoothstep(limit - soft, limit + soft, value), seen);
}

// 0..1 in the pattern of foam that covers a share of the water, 1 where it lies: threads around bubbles and patches.
// The mean over the water is about the share, and that is what is left where a pixel is too large for the pattern.
float foam_pattern(vec3 D, float footprint_m, float share) {
    float coarse = clamp(1.5 - 3.0 * footprint_m / FOAM_COARSE_M, 0.0, 1.0);
    float fine = clamp(1.5 - 3.0 * footprint_m / FOAM_FINE_M, 0.0, 1.0);
    float value = 0.0, bubbles = 0.0;
    int turns = share > 0.015 && coarse > 0.0 ? (fine > 0.0 ? 3 : 1) : 0;
    int i = 0;
    if (turns > 0) do {
        float n = sea_noise(D, i == 0 ? 4 : i == 1 ? 2 : 1);
        bubbles += i == 0 ? 0.0 : n;
        value += i == 0 ? 0.7 * coarse * n : (i == 1 ? 0.85 : 0.5) * fine * (0.78 - abs(n)) * 1.6;
    } while (++i < turns);
    // The share's quantile of a normal distribution, nearly.
    float c = clamp(share, 1e-3, 0.999), deviation = max(0.7 * coarse + 0.3 * fine, 1e-3);
    float limit = -log(c / (1.0 - c)) * 0.59 * deviation;
    float soft = mix(4.0, 0.6, coarse) * deviation;
    float cover = smoothstep(limit - soft, limit + soft, value);
    // Thin in places.
    cover *= 1.0 - 0.45 * fine * smoothstep(-0.2, 1.2, bubbles);
    return turns == 0 ? share : mix(share, cover, coarse);
}
