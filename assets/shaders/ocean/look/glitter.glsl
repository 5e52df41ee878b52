// The sun mirrored by the slopes that a pixel hides: single reflection by facets, masked on both ways (Smith's, height
// correlated: Heitz 2014, equation 99; for slopes: Bruneton, Neyret and Holzschuh 2010).
#include "ocean/look/fresnel.glsl"

// Radiance per irradiance on a surface that faces the sun. v, l: towards the eye and the sun, level frame. The disc
// (angular radius `sun_radius`) widens the slopes that mirror it: without that, smooth water would mirror a point.
float glitter(Slopes slopes, SlopesSeen seen, vec3 v, vec3 l, float sun_radius, float index) {
    vec3 h = normalize(v + l);
    // A disc of radius a has the variance a^2 / 4 along each axis; facets turn by half of that, and their slope by 1 /
    // h_z^2 more along the plane of incidence, 1 / h_z across.
    slopes.variance.xy += sun_radius * sun_radius / (16.0 * h.z * h.z);
    float v_h = dot(v, h);
    SlopesSeen lit = slopes_seen(slopes, l);
    // Of facets that the eye sees and the sun lights: 1 / (1 + L_v + L_l), L = area / facing - 1.
    float unlit = lit.area / max(lit.facing, 1e-3 * lit.area) - 1.0;
    float area = seen.area + max(seen.facing, 0.0) * max(unlit, 0.0);
    float facets = slopes_facets(slopes, -h.xy / h.z);
    float h2 = h.z * h.z;
    return l.z <= -0.02 || h.z < 0.02 ? 0.0 : facets * fresnel_outside(v_h, index) / (4.0 * h2 * h2 * max(area, 1e-4));
}
