// A rough surface as a Gaussian of slopes about a mean slope (Cox and Munk 1954), and what of it a direction sees:
// masked by Smith's method, exactly for such a surface (Bourlier et al. 2000; Bruneton, Neyret and Holzschuh 2010 for
// seas). Directions are in a level frame (x, y aside, z up); a facet with slope s has the normal (-s, 1) / |..|. Seen
// from a direction v its projected area per level area is v_z - dot(s, v_xy).
//
// Tests against Monte-Carlo: tests/systems/test_water_light.py.
#include "common/constants.glsl"

struct Slopes {
    vec2 mean;
    vec3 variance;   // of x, of y, covariance
};

float slopes_variance_along(Slopes s, vec2 unit) {
    return max(s.variance.x * unit.x * unit.x + s.variance.y * unit.y * unit.y + 2.0 * s.variance.z * unit.x * unit.y,
        1e-9);
}

// The cumulated normal distribution, to 1.5e-4 (Bowling et al. 2009), and its density.
float slopes_below(float t) {
    return 1.0 / (1.0 + exp(-t * (1.5976 + 0.07056 * t * t)));
}

float slopes_density(float t) {
    return 0.398942280 * exp(-0.5 * t * t);
}

// The level part of a direction, unit; straight up any will do.
vec2 slopes_aside(vec3 v) {
    float aside = length(v.xy);
    return aside > 1e-6 ? v.xy / aside : vec2(1.0, 0.0);
}

// What a direction sees of the surface.
struct SlopesSeen {
    float area;      // mean over all facets of their projected area, back sides as 0: v_z for a smooth level surface
    float facing;    // the projected area of the mean facet; negative: its back
    float mean;      // of the slopes seen, along the direction's level part (weighted with the area that shows)
    float spread;    // their standard deviation
};

SlopesSeen slopes_seen(Slopes s, vec3 v) {
    vec2 along = slopes_aside(v);
    float aside = max(length(v.xy), 1e-6), mean = dot(s.mean, along), sigma = sqrt(slopes_variance_along(s, along));
    SlopesSeen seen;
    seen.facing = v.z - aside * mean;
    // A mean facet turned away by five deviations shows nothing that counts; from far above all facets show.
    float t = clamp(seen.facing / (aside * sigma), -5.0, 1e3);
    float below = slopes_below(t), density = slopes_density(t), area = max(t * below + density, 1e-7);
    seen.area = t >= 1e3 ? seen.facing : aside * sigma * area;
    float first = -below / area, second = (t * below + 2.0 * density) / area;
    seen.mean = mean + sigma * first;
    seen.spread = sigma * sqrt(max(second - first * first, 0.0));
    return seen;
}

// Density of facets with a slope, per unit of slope squared.
float slopes_facets(Slopes s, vec2 slope) {
    vec2 d = slope - s.mean;
    float area2 = max(s.variance.x * s.variance.y - s.variance.z * s.variance.z, 1e-16);
    float square = (s.variance.y * d.x * d.x + s.variance.x * d.y * d.y - 2.0 * s.variance.z * d.x * d.y) / area2;
    return exp(-0.5 * square) * inversesqrt(area2) * (0.5 / PI);
}
