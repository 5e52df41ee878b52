// What the air emits towards the camera for a unit sun: sunlight scattered once by molecules plus all light scattered
// more often, over Rayleigh's phase function (first kind), and sunlight scattered once by aerosols, without its phase
// function (second kind). Both phase functions are known exactly where the tables are read, and would be blurred by
// their steps.
#include "atmosphere/sunlight.glsl"
#include "atmosphere/moments.glsl"
#include "atmosphere/column.glsl"

// 1 where light that was scattered more than once counts, 0 for single scattering.
float air_orders = 1.0;

AirFolded air_before = AirFolded(vec3(0.0), vec3(0.0));   // in the slice at hand

void column_middle(float h, float mu, float mu_s, float nu) {
    air_before = air_folded(h, mu, mu_s, nu);
}

void column_source(float h, float mu, float mu_s, float nu, vec3 density, out vec3 first, out vec3 second) {
    vec3 sun = air_sun(h, mu_s);
    first = density.x * air_model.rayleigh_per_m * sun
        + air_orders / air_rayleigh_phase(nu) * air_multiple(air_before, density);
    second = density.y * air_model.mie_scattering_per_m * sun;
}

// Source over extinction where a ray starts: the mean over a path of length 0.
void air_start_means(AirColumn c, out vec3 first, out vec3 second) {
    vec3 density = air_density(c.h), extinction = air_extinction(density);
    column_middle(c.h, c.mu, c.mu_s, c.nu);
    column_source(c.h, c.mu, c.mu_s, c.nu, density, first, second);
    first /= max(extinction, 1e-30);
    second /= max(extinction, 1e-30);
}
