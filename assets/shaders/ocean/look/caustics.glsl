// Light that waves gather on the bed, as a factor of mean one: bright lines where two drifting noises pass zero
// together. Sharpest where the depth is that of the ripples' focus, a few wavelengths; blurred by the sun's disc and
// more ripples below.
#include "common/constants.glsl"
#include "common/camera.glsl"
#include "ocean/look/noise.glsl"

float water_caustics(vec3 D, float depth_m, float footprint_m) {
    float seen = ocean.caustics * clamp(1.5 - footprint_m * 5.0, 0.0, 1.0) * smoothstep(0.02, 0.5, depth_m)
        * exp(-0.12 * depth_m);
    float bright = 1.0;
    int turns = seen > 0.004 ? 2 : 0;
    float near = 1.0;
    vec3 up = frame.anchor_up, side = normalize(cross(up, up.yzx + vec3(0.0, 0.1, 0.3)));
    int i = 0;
    if (turns > 0) do {
        float angle = TWO_PI * fract(frame.time_s * (i == 0 ? 31.0 / 4096.0 : -43.0 / 4096.0));
        vec3 drift = (up * sin(angle) + side * cos(angle)) * 6.0;
        float n = sea_noise(D + drift, 3);
        near = i == 0 ? abs(n) : min(near, abs(n)) + 0.3 * abs(near - abs(n));
    } while (++i < turns);
    // Mean of the power over the noise: measured 0.30.
    float line = max(1.0 - 0.8 * near, 0.0);
    line *= line;
    bright = turns == 0 ? 1.0 : mix(1.0, 0.35 + line * line * 2.15, seen);
    return bright;
}
