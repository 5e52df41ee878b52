// Sea ice towards the poles.
#include "ocean/look/pixel.glsl"

// Share of ice (x) and its shade (y): closed towards the pole, floes at its edge, two octaves of noise that follow the
// footprint.
vec2 sea_ice(SeaPixel p) {
    float octave = log2(max(5.0 * p.footprint_m / NESTED_BASE_M, 1.0)) / 3.0;
    float low = min(floor(octave), 8.0), t = smoothstep(0.0, 1.0, clamp(octave - low, 0.0, 1.0));
    float beyond = (abs(p.zenith.z) - ocean.ice_sine) * 60.0;
    int turns = beyond < -6.0 ? 0 : beyond < 6.0 ? 2 : 1, k = 3 * int(low) + 1;
    float noise = 0.0;
    int i = 0;
    if (turns > 0) do {
        noise += (i == 0 ? 1.0 - 0.6 * t : 0.4 + 0.6 * t) * sea_noise(p.D, k);
        k += 3;
    } while (++i < turns);
    return vec2(smoothstep(-0.3, 0.3, beyond + 0.6 * noise), 1.0 + 0.07 * noise);
}
