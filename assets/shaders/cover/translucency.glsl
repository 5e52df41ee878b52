// How open leaves are and what they let through, both in the upper half of 8 bits: 18 and 7 steps.
const float OPEN_STEPS = 17.0, THROUGH_STEP = 0.15, THROUGH_STEPS = 7.0;

// open: 0..1; translucency: 0..0.9.
float coded_light(float open, float translucency) {
    float through = min(round(translucency / THROUGH_STEP), THROUGH_STEPS - 1.0);
    return (128.0 + THROUGH_STEPS * round(OPEN_STEPS * clamp(open, 0.0, 1.0)) + through) / 255.0;
}

// (open, translucency) of a value above 0.5.
vec2 decoded_light(float coded) {
    float steps = round(255.0 * coded) - 128.0, open = floor((steps + 0.5) / THROUGH_STEPS);
    return vec2(open / OPEN_STEPS, THROUGH_STEP * (steps - THROUGH_STEPS * open));
}
