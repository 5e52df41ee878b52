// How much light a water surface throws back.
#include "ocean/look/slopes.glsl"

// Fresnel's equations for unpolarised light, from outside at this cosine; index: of refraction of the liquid over the
// air's.
float fresnel_outside(float cosine, float index) {
    float inside = sqrt(max(index * index - 1.0 + cosine * cosine, 0.0));   // index times the refracted cosine
    float s = (cosine - inside) / (cosine + inside);
    float p = (cosine * inside - (1.0 - cosine * cosine)) / (cosine * inside + (1.0 - cosine * cosine));
    return 0.5 * s * s * (1.0 + p * p);
}

// The same from inside; 1 beyond the critical angle.
float fresnel_inside(float cosine, float index) {
    float out2 = 1.0 - index * index * (1.0 - cosine * cosine);
    float outside = sqrt(max(out2, 0.0));
    float s = (index * cosine - outside) / (index * cosine + outside);
    float p = (cosine - index * outside) / (cosine + index * outside);
    return out2 <= 0.0 ? 1.0 : 0.5 * (s * s + p * p);
}

// Mean of Fresnel's term over the facets that a direction sees, by two facets one deviation to either side of their
// mean: exact for what varies as a cubic of the slope, within 2 % of Monte-Carlo from smooth water to slopes of 0.2 at
// all angles. `slope`: their mean slope along the direction weighted with what they throw back, the facet that mirrors
// on average.
float fresnel_mean(Slopes slopes, SlopesSeen seen, vec3 v, float index, out float slope) {
    vec2 aside = slopes_aside(v), side = vec2(-aside.y, aside.x);
    float across = dot(slopes.mean, side), across2 = across * across + slopes_variance_along(slopes, side);
    vec2 s = seen.mean + seen.spread * vec2(-1.0, 1.0);
    vec2 cosine = clamp((v.z - length(v.xy) * s) * inversesqrt(1.0 + s * s + across2), 1e-4, 1.0);
    vec2 share = vec2(fresnel_outside(cosine.x, index), fresnel_outside(cosine.y, index));
    slope = dot(share, s) / (share.x + share.y);
    return 0.5 * (share.x + share.y);
}
