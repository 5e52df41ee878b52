// A wave's 28 bytes (systems/ocean/wave_record.py), as they are printed and as they are at an anchor.
//
//   Wave  paper_wave(WaveRecord at)                                   at an anchor: what ocean/waves.glsl takes
//   float paper_arc(int year, vec3 v, vec3 o, float radius_m)         as printed: from its origin, m
//   vec2  paper_fade(float cycles_per_m)                              1 - cos of the angles where it begins to be there
//   and is whole
#include "generated/wave_record.glsl"
#include "ocean/wave_block.glsl"
uniform vec4 u_fade;   // fade_lengths()

vec2 paper_fade(float cycles_per_m) {
    vec2 angle = min(u_fade.xy / cycles_per_m, u_fade.zw), square = angle * angle;
    return square * (0.5 - square * (1.0 / 24.0 - square / 720.0));
}

Wave paper_wave(WaveRecord at) {
    vec2 away = -vec2(at.origin_x, at.origin_y);
    float sine = max(sqrt(dot(away, away)), 1e-18), half_cotangent = 0.5 * at.origin_z / sine;
    float radius = sea_waves.radius_m, half_per_m = half_cotangent / radius;
    Wave wave;
    wave.heading = dot(away, away) > 0.0 ? away / sine : vec2(1.0, 0.0);
    wave.phase_cycles = at.turn;
    wave.cycles_per_m = at.wave_number;
    wave.amplitude_m = at.amplitude_m;
    wave.sideways_m = at.steepness * at.amplitude_m;
    wave.half_cotangent_per_m = half_per_m;
    wave.curve_per_m2 = 2.0 * half_per_m * half_per_m + (1.0 / 6.0) / (radius * radius);
    wave.origin_cos = at.origin_z;
    wave.origin_sin = sine;
    vec2 fade = paper_fade(at.wave_number);
    wave.fade_from = fade.x;
    wave.fade_to = fade.y;
    return wave;
}

// Michelic 2018, equation 7, and Michelic et al. 2019, in single precision: the arccosine is lost near the origin and
// its antipode, the arcsine near the antipode, and both in what a driver's functions are good to.
float paper_arc(int year, vec3 v, vec3 o, float radius_m) {
    return year == 2018 ? acos(clamp(dot(v, o), -1.0, 1.0)) * radius_m
        : 2.0 * radius_m * asin(min(0.5 * length(v - o), 1.0));
}
