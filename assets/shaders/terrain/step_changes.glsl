// Changes of what statements of the height function call (systems/terrain/height_steps.py), from t (n) by d: as exact
// as d. Where they are clamped they do not rise, so that it does not matter how exactly t is known there.

// clamp(t, low, high) at t + d less that at t.
float terrain_clamp_change(float t, float d, float low, float high) {
    float inside = clamp(t, low, high);
    return clamp((t - inside) + d, low - inside, high - inside);
}

float terrain_smoothstep_change(float t, float d) {
    d = terrain_clamp_change(t, d, 0.0, 1.0);
    t = clamp(t, 0.0, 1.0);
    return d * (6.0 * t * (1.0 - t) + d * (3.0 - 6.0 * t - 2.0 * d));
}

float terrain_bump_change(float t, float d) {
    float from = max(1.0 - t * t, 0.0);
    d = max(min(1.0 - t * t, 0.0) - d * (2.0 * t + d), -from);
    return d * (2.0 * from + d);
}

float terrain_positive_change(float t, float d) {
    return t > 0.0 ? max(d, -t) : max(t + d, 0.0);
}

float terrain_ridge_change(float n, float d, float ridge) {
    float middle = clamp(n, -TERRAIN_RIDGE_ROUND, TERRAIN_RIDGE_ROUND), outer = n - middle;
    float d_middle = terrain_clamp_change(n, d, -TERRAIN_RIDGE_ROUND, TERRAIN_RIDGE_ROUND);
    float d_outer = d - d_middle, there = outer + d_outer;
    float a = d_middle * (2.0 * middle + d_middle) * (0.5 / TERRAIN_RIDGE_ROUND)
        + (outer * there < 0.0 ? abs(there) - abs(outer) : outer + there < 0.0 ? -d_outer : d_outer);
    return (1.0 - abs(ridge)) * d - ridge * TERRAIN_RIDGE_SLOPE * a;
}
