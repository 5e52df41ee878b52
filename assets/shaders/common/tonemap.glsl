// Tone maps: exposed linear colour (1 = saturated) to display-encoded colour in 0..1. TONE_MAP chooses at compile time.
// Twin with the sources: systems/composite/tone_maps.py. Inputs of all but the camera's are scaled so that 0.18 stays
// 0.18.
#include "common/color.glsl"

#define TONE_MAP_CAMERA 0
#define TONE_MAP_AGX 1
#define TONE_MAP_ACES 2
#define TONE_MAP_HABLE 3
#define TONE_MAP_REINHARD 4
#define TONE_MAP_NEUTRAL 5
#define TONE_MAP_LINEAR 6

// Lifts a colour towards white by how far its brightest channel was pressed, so that what is far too bright is white.
vec3 bleached(vec3 color, float pressed, float peak) {
    return mix(color, vec3(pressed), 1.0 - 1.0 / (0.15 * (peak - pressed) + 1.0));
}

#if TONE_MAP == TONE_MAP_CAMERA
// A camera's picture with white at exposed 1 (docs/exposure.md): the curve acts on the brightest channel, which keeps
// hue and saturation, then bleaches.
vec3 tone_map(vec3 exposed) {
    const float GAIN = 1.17, TOE = 0.0043, ROLL_OFF = 0.267, START = 0.9, SPAN = 0.1;
    float peak = clamp(max(exposed.r, max(exposed.g, exposed.b)), 1e-6, 1e6);
    float lifted = GAIN * peak * peak / (peak + TOE);
    float pressed = lifted / (1.0 + ROLL_OFF * lifted);
    if (pressed > START) pressed = 1.0 - SPAN * SPAN / (pressed + SPAN - START);
    vec3 color = min(exposed, 1e6) * (pressed / peak);
    return srgb_encode(peak > pressed ? bleached(color, pressed, peak) : color);
}
#elif TONE_MAP == TONE_MAP_AGX
// v^1.2 for 0..1 to within 4e-6, 1 for 1; pow takes several times as long.
vec3 contrast(vec3 v) {
    vec3 root = sqrt(sqrt(v));
    return v * (0.0487611 + root * (1.2288023 + root * (-0.4628664 + root * (0.2445177 - 0.0592147 * root))));
}

// AgX (Sobotka 2022), curve by the polynomial fit of Wrensch 2023; it gives display values, no sRGB encoding follows.
// Its base is flat by design and wants a look: contrast about middle grey that leaves black and white where they are,
// and saturation.
vec3 tone_map(vec3 exposed) {
    const mat3 INTO = mat3(0.842479062253094, 0.0423282422610123, 0.0423756549057051,
                           0.0784335999999992, 0.878468636469772, 0.0784336,
                           0.0792237451477643, 0.0791661274605434, 0.879142973793104);
    const mat3 BACK = mat3(1.19687901, -0.05289685, -0.05297164,
                           -0.09802088, 1.15190313, -0.09804345,
                           -0.09902974, -0.09896118, 1.15107367);
    const float LOW = -12.47393, HIGH = 4.026069;
    vec3 v = log2(max(INTO * (exposed * 0.821), vec3(1e-10)));
    v = (clamp(v, LOW, HIGH) - LOW) * (1.0 / (HIGH - LOW));
    v = (((((15.5 * v - 40.14) * v + 31.96) * v - 6.868) * v + 0.4298) * v + 0.1191) * v - 0.00232;
    const float GREY = 0.46114, SATURATED = 1.35;
    v = clamp(v, 0.0, 1.0);
    bvec3 bright = greaterThan(v, vec3(GREY));
    vec3 bent = contrast(mix(v * (1.0 / GREY), (1.0 - v) * (1.0 / (1.0 - GREY)), bright));
    v = mix(GREY * bent, 1.0 - (1.0 - GREY) * bent, bright);
    v = mix(vec3(dot(v, LUMINANCE_WEIGHTS)), v, SATURATED);
    return clamp(BACK * v, 0.0, 1.0);
}
#elif TONE_MAP == TONE_MAP_ACES
// Stephen Hill's fit of the ACES transforms for sRGB.
vec3 tone_map(vec3 exposed) {
    const mat3 INTO = mat3(0.59719, 0.07600, 0.02840, 0.35458, 0.90834, 0.13383, 0.04823, 0.01566, 0.83777);
    const mat3 BACK = mat3(1.60475, -0.10208, -0.00327, -0.53108, 1.10813, -0.07276, -0.07367, -0.00605, 1.07602);
    vec3 v = INTO * (min(exposed, vec3(1e5)) * 1.462);
    v = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081);
    return srgb_encode(BACK * v);
}
#elif TONE_MAP == TONE_MAP_HABLE
// Hable 2010, white at 11.2.
vec3 film(vec3 v) {
    return (v * (0.15 * v + 0.05) + 0.004) / (v * (0.15 * v + 0.5) + 0.06) - 0.02 / 0.3;
}
vec3 tone_map(vec3 exposed) {
    return srgb_encode(film(min(exposed, vec3(1e5)) * 2.928) / film(vec3(11.2)));
}
#elif TONE_MAP == TONE_MAP_REINHARD
// Reinhard et al. 2002, eq. 4, on luminance, white at 6.
vec3 tone_map(vec3 exposed) {
    vec3 v = exposed * 1.211;
    float grey = dot(v, LUMINANCE_WEIGHTS);
    return srgb_encode(v * ((1.0 + grey * (1.0 / 36.0)) / (1.0 + grey)));
}
#elif TONE_MAP == TONE_MAP_NEUTRAL
// Khronos PBR neutral 2024.
vec3 tone_map(vec3 exposed) {
    vec3 v = exposed * 1.222;
    float least = min(v.r, min(v.g, v.b));
    v -= least < 0.08 ? least - 6.25 * least * least : 0.04;
    float peak = max(v.r, max(v.g, v.b));
    const float START = 0.76, SPAN = 0.24;
    float high = max(peak, START);
    float pressed = 1.0 - SPAN * SPAN / (high + SPAN - START);
    return srgb_encode(peak < START ? v : bleached(v * (pressed / high), pressed, high));
}
#else
vec3 tone_map(vec3 exposed) {
    return srgb_encode(exposed);
}
#endif
