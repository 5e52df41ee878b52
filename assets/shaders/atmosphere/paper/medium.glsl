// The air itself: densities at an altitude, and how it scatters.
#include "generated/air_model.glsl"
#include "common/safe.glsl"

// Relative densities of (molecules, aerosols, absorber) at altitude h.
vec3 paper_densities(float h) {
    float away = abs(h - air_model.absorber_height_m) * air_model.absorber_slope_per_m;
    return vec3(exp(-h / air_model.rayleigh_height_m), exp(-h / air_model.mie_height_m), max(1.0 - away, 0.0));
}

float paper_rayleigh_phase(float nu) {
    return 3.0 / (16.0 * PI) * (1.0 + nu * nu);
}

// Cornette and Shanks 1992. Forward scattering with g near 1 has a peak whose base rounds to 0 at nu = 1.
float paper_mie_phase(float nu) {
    float g = air_model.mie_asymmetry;
    float base = max(1.0 + g * g - 2.0 * g * nu, 1e-8);
    return 3.0 / (8.0 * PI) * (1.0 - g * g) / (2.0 + g * g) * (1.0 + nu * nu) / (base * sqrt(base));
}
