// Light that was scattered more than once. Its source function is the phase function folded with the incident radiance
// L; both expand in spherical harmonics about the zenith, the azimuth counted from the sun:
//
//   J(omega) = sum over l <= AIR_DEGREE, 0 <= m <= l of a_l S_lm P_lm(mu) cos(m phi),
//   S_lm = (2l + 1) / (4 pi) (2 - [m = 0]) (l - m)! / (l + m)! * integral of L P_lm cos(m phi)
//
// (addition theorem). Rayleigh's phase function has a_0 = 1, a_2 = 1/10 and nothing else, so degree 2 is exact for it;
// of Mie's the light that is scattered forward again and again is what a low degree blurs, never its energy.
//
// The table holds the fourth root of S_00 and, in layer l (l + 1) / 2 + m after it, the ratio S_lm / (S_00 sin^m of the
// sun's zenith angle), which is smooth at the zenith.
#include "atmosphere/table.glsl"

const int AIR_MOMENTS = (AIR_DEGREE + 1) * (AIR_DEGREE + 2) / 2;

// Moment of Mie's phase function, 2 pi times the integral of p P_l.
float air_mie_moment(int l) {
    return l == 0 ? 1.0 : air_model.mie_moments[min(l - 1, 3)];
}

// How much of a degree's own moment counts, and not that of the lobe below: less towards the end of the series.
float air_mie_trust(int l) {
    return l < 3 ? 1.0 : float(AIR_DEGREE + 1 - l) / float(AIR_DEGREE - 1);
}

// Light that has been scattered before, folded with a phase function: radiance per scattering coefficient.
struct AirFolded {
    vec3 rayleigh, mie;
};

// Into the direction with cosine mu to the zenith and nu to the sun.
//
// Of haze a low degree would leave rings of dark and light around the sun (a series that breaks off). So the light that
// comes in is taken for a lobe of Henyey and Greenstein's about its mean direction f, as narrow as |f| says, which
// folded with a phase function of asymmetry g is the same with g |f|; the series then holds the difference from that
// lobe's own moments.
AirFolded air_folded(float h, float mu, float mu_s, float nu) {
    AirPlace place = air_place(h, mu_s);
    float x = nu - mu * mu_s;                                         // sin sin_s cos(phi)
    float rho2 = max((1.0 - mu * mu) * (1.0 - mu_s * mu_s), 0.0);     // (sin sin_s)^2
    x = clamp(x, -sqrt(rho2), sqrt(rho2));
    vec3 ahead = air_moment(place, AIR_IRRADIANCE_LAYERS + 1), aside = air_moment(place, AIR_IRRADIANCE_LAYERS + 2);
    float g = air_mie_moment(1);
    // The lobe's asymmetry times its cosine to the direction, and its asymmetry squared, no more than the phase
    // function's.
    vec3 along = (g / 3.0) * (mu * ahead + x * aside);
    vec3 narrow2 = (g * g / 9.0) * (ahead * ahead + max(1.0 - mu_s * mu_s, 0.0) * aside * aside);
    vec3 within = min(vec3(1.0), abs(g) * inversesqrt(max(narrow2, 1e-20)));
    along *= within;
    narrow2 *= within * within;
    vec3 spread = max(1.0 + narrow2 - 2.0 * along, 1e-4);
    vec3 mie = (1.0 - narrow2) * inversesqrt(spread) / spread;
    vec3 lobe = along, lobe_last = vec3(1.0);                         // its asymmetry^l P_l of its cosine
    for (int l = 0; l <= AIR_DEGREE; ++l) {
        vec3 part = l == 0 ? vec3(1.0) : lobe;
        mie -= air_mie_trust(l) * float(2 * l + 1) * part;
        vec3 next = (float(2 * l + 1) * along * lobe - float(l) * narrow2 * lobe_last) / float(l + 1);
        lobe_last = l == 0 ? lobe_last : lobe;
        lobe = l == 0 ? lobe : next;
    }
    vec3 rayleigh = vec3(0.0);
    float turn = 1.0, turn_last = 0.0, diagonal = 1.0;                // (sin sin_s)^m cos(m phi); P_mm / sin^m
    for (int m = 0; m <= AIR_DEGREE; ++m) {
        float p = diagonal, p_last = 0.0;
        for (int l = m; l <= AIR_DEGREE; ++l) {
            vec3 term = l == 0 ? vec3(1.0) : air_moment(place, AIR_IRRADIANCE_LAYERS + l * (l + 1) / 2 + m);
            term *= p * turn;
            mie += air_mie_trust(l) * air_mie_moment(l) * term;
            rayleigh += l == 0 ? term : l == 2 ? 0.1 * term : vec3(0.0);
            float p_next = (float(2 * l + 1) * mu * p - float(l + m) * p_last) / float(l + 1 - m);
            p_last = p;
            p = p_next;
        }
        diagonal *= float(2 * m + 1);
        float turn_next = m == 0 ? x : 2.0 * x * turn - rho2 * turn_last;
        turn_last = turn;
        turn = turn_next;
    }
    vec3 mean = air_unpack(air_moment(place, AIR_IRRADIANCE_LAYERS));
    return AirFolded(mean * max(rayleigh, 0.0), mean * max(mie, 0.0));
}

// Emission per metre of air of this density.
vec3 air_multiple(AirFolded light, vec3 density) {
    return density.x * air_model.rayleigh_per_m * light.rayleigh
        + density.y * air_model.mie_scattering_per_m * light.mie;
}
