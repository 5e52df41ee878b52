// Guards against the few arguments that break a formula. Each says which camera or point needs it.
#include "common/constants.glsl"


// sqrt of what is mathematically >= 0. A ray that grazes a sphere (camera looking along the horizon) has a discriminant
// that rounds to just below 0, and NaN spreads from there through every blend and filter.
float safe_sqrt(float x) {
    return sqrt(max(x, 0.0));
}

// A cosine from a dot product of unit vectors: 1 + 6e-8 for a camera looking straight up or down, where 1 - mu^2 < 0.
float clamp_cos(float mu) {
    return clamp(mu, -1.0, 1.0);
}

// Sine belonging to a cosine. Straight up or down (see clamp_cos).
float sin_from_cos(float mu) {
    return safe_sqrt((1.0 - mu) * (1.0 + mu));
}

// Zero counts as positive: sign(0.0) is 0 and loses a level ray (mu = 0, camera looking exactly at the geometric
// horizon).
float sign_nonzero(float x) {
    return x < 0.0 ? -1.0 : 1.0;
}

vec2 sign_nonzero(vec2 v) {
    return vec2(sign_nonzero(v.x), sign_nonzero(v.y));
}

vec3 sign_nonzero(vec3 v) {
    return vec3(sign_nonzero(v.x), sign_nonzero(v.y), sign_nonzero(v.z));
}

// Unit vector, or `fallback` for a zero vector: the camera exactly above the point (no horizontal direction to it), or
// a normal that cancelled.
vec3 safe_normalize(vec3 v, vec3 fallback) {
    // Scaled first: the square of 1e25 m overflows, that of 1e-25 m vanishes.
    float largest = max(max(abs(v.x), abs(v.y)), abs(v.z));
    if (!(largest > 0.0)) {
        return fallback;
    }
    v /= largest;
    return v * inversesqrt(dot(v, v));
}

// a / b for b >= 0 that may be 0: optical depth 0 (camera in space, looking away from the air).
float safe_divide(float a, float b, float fallback) {
    return b > 0.0 ? a / b : fallback;
}

// sin and cos by polynomials, |x| <= pi / 2. The built-in ones promise an absolute error only (drivers give up to
// 2^-11), so a camera 1 m above ground, whose angles to its neighbours are 1e-7 rad, would see them all at angle 0.
// Relative error of pf_sin_small <= 1.2e-7 everywhere; of pf_cos <= 1.2e-7 for |x| <= 1.3, absolute <= 1.2e-7 beyond
// (it passes through 0).
float pf_sin_small(float x) {
    float s = x * x;
    float p = 2.605780603e-6;
    p = p * s - 1.980960288e-4;
    p = p * s + 8.333066246e-3;
    p = p * s - 1.666665955e-1;
    return x + x * s * p;
}

float pf_cos(float x) {
    float s = x * x;
    float p = -2.619381473e-7;
    p = p * s + 2.476930421e-5;
    p = p * s - 1.388856916e-3;
    p = p * s + 4.166665577e-2;
    return 1.0 - s * (0.5 - s * p);
}

// 1 - cos(x) without cancellation, |x| <= pi: the drop of the horizon below the camera's level, 1e-14 of the radius at
// 1 m.
float pf_one_minus_cos(float x) {
    float h = pf_sin_small(0.5 * x);
    return 2.0 * h * h;
}

// (1 - exp(-x)) / x for x >= 0: the mean transmittance along a uniform segment. 0 / 0 for rays through empty space.
float one_minus_exp_over(float x) {
    if (x < 0.02) {
        return 1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0)));
    }
    return (1.0 - exp(-x)) / x;
}

vec3 one_minus_exp_over(vec3 x) {
    return vec3(one_minus_exp_over(x.x), one_minus_exp_over(x.y), one_minus_exp_over(x.z));
}
