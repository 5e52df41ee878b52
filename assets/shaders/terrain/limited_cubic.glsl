// A cubic whose slopes are limited: engine/real_ground/limited_cubic.py, which derives it. Four curves at once; taps
// are differences from any one of them.

// Slopes by sample at samples with the steps a before and b after them, and their derivatives by both.
vec4 limited_slope(vec4 a, vec4 b, out vec4 by_a, out vec4 by_b) {
    vec4 size = abs(a) + abs(b), over_size = 1.0 / max(size, 1e-30);
    vec4 x = a * over_size, y = b * over_size, p = x * y, q = x * x + y * y, s = x + y;
    vec4 below = 1.0 / max(q * q + 4.0 * p * p, 1e-30), found = 2.0 * p * s * q * below;
    by_a = (2.0 * (y * s * q + p * q + 2.0 * p * s * x) - found * (4.0 * x * q + 8.0 * p * y)) * below;
    by_b = (2.0 * (x * s * q + p * q + 2.0 * p * s * y) - found * (4.0 * y * q + 8.0 * p * x)) * below;
    return size * found;
}

// Four curves through taps t0 to t3 at f between the second and the third: values over the second, derivatives by f.
vec4 limited_cubic(vec4 t0, vec4 t1, vec4 t2, vec4 t3, float f, out vec4 slope) {
    vec4 b = t2 - t1, by_a, by_b, m0 = limited_slope(t1 - t0, b, by_a, by_b),
        m1 = limited_slope(b, t3 - t2, by_a, by_b);
    float g = 1.0 - f;
    slope = 6.0 * f * g * b + g * (1.0 - 3.0 * f) * m0 - f * (2.0 - 3.0 * f) * m1;
    return f * f * (3.0 - 2.0 * f) * b + f * g * g * m0 - f * f * g * m1;
}

// One curve through four taps that change by d: the value over the second, the derivative by f, and the change.
float limited_cubic(vec4 taps, vec4 d, float f, out float slope, out float change) {
    vec3 rise = taps.yzw - taps.xyz, moved = d.yzw - d.xyz;
    vec4 by_a, by_b, m = limited_slope(rise.xyxy, rise.yzyz, by_a, by_b);
    float g = 1.0 - f, whole = f * f * (3.0 - 2.0 * f), in0 = f * g * g, in1 = f * f * g;
    slope = 6.0 * f * g * rise.y + g * (1.0 - 3.0 * f) * m.x - f * (2.0 - 3.0 * f) * m.y;
    vec2 turned = by_a.xy * moved.xy + by_b.xy * moved.yz;
    change = d.y + whole * moved.y + in0 * turned.x - in1 * turned.y;
    return whole * rise.y + in0 * m.x - in1 * m.y;
}
