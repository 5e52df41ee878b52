// The picture between exposure and tone map, as anti-aliasing keeps it: exposed colour, pressed into 0..1
// by x / (1 + (max x)^4)^(1/4). That is nearly what a display shows of it (docs/antialiasing.md), so a mean of samples
// here is what an eye sees of many small pixels; a sun weighs little more than white paper.
#include "common/color.glsl"

vec3 exposed_light(vec3 radiance, float saturated) {
    // A comparison that fails for NaN as well: it becomes black instead of spreading.
    vec3 light = mix(vec3(0.0), radiance, greaterThan(radiance, vec3(0.0)));
    return min(display_light(light) * (1.0 / saturated), vec3(1e6));
}

float fourth_power(float x) {
    return x * x * x * x;
}

vec3 press(vec3 light) {
    float peak = max(light.r, max(light.g, light.b));
    return light * sqrt(inversesqrt(1.0 + fourth_power(peak)));
}

vec3 unpress(vec3 pressed) {
    float peak = max(pressed.r, max(pressed.g, pressed.b));
    return pressed * sqrt(inversesqrt(max(1.0 - fourth_power(peak), 1e-6)));
}

// What was pressed at another exposure; `ratio`: of the saturating luminances then and now.
vec3 press_again(vec3 pressed, float ratio) {
    float peak = max(pressed.r, max(pressed.g, pressed.b));
    return pressed * (ratio * sqrt(inversesqrt(1.0 + (fourth_power(ratio) - 1.0) * fourth_power(peak))));
}

// What lies at a pixel, as a whole number below 2^20 that a float holds exactly: distance along the view in steps of a
// 32th of an octave from 2^-16 m (11 bits, the last one infinity), surface (3 bits), frames that its colour was
// gathered over (6 bits).
const int PLACE_SKY = 2047, PLACE_FRAMES = 63;

int place_distance(float per_m) {
    return per_m > 0.0 ? clamp(int((16.0 - log2(per_m)) * 32.0 + 0.5), 0, PLACE_SKY - 1) : PLACE_SKY;
}

// The inverse, 0 for what is infinitely far.
float place_per_m(int code) {
    return code < PLACE_SKY ? exp2(16.0 - float(code) * (1.0 / 32.0)) : 0.0;
}

float place_code(int code, uint surface, int frames) {
    return float((code << 9) | (int(min(surface, 7u)) << 6) | min(frames, PLACE_FRAMES));
}
