// Water along a ray below the surface: what it takes away and what it scatters into the ray, sun and skylight fading
// with depth.
#include "common/constants.glsl"
#include "ocean/look/column.glsl"

const float SKY_COSINE = 0.86;   // of diffuse light below the surface, in the mean

struct WaterSun {
    vec3 to_sun;     // refracted, unit
    float cosine;    // of it to the vertical
    vec3 direct;     // irradiance just below the surface on a plane across it
    vec3 diffuse;    // of the sky, downwards
};

WaterSun water_sun(vec3 zenith, vec3 sunlight, vec3 skylight, float mirrored) {
    WaterSun s;
    vec3 sun = frame.sun_direction;
    float above = max(dot(sun, zenith), 1e-3);
    s.cosine = refracted_cosine(above);
    s.to_sun = normalize((sun - zenith * above) / ocean.refractive_index + zenith * s.cosine);
    s.direct = sunlight * ((1.0 - mirrored) * above / s.cosine);
    s.diffuse = skylight * (1.0 - ocean.diffuse_mirrored);
    return s;
}

// Sunlight scattered forward makes a glow around the sun: Henyey and Greenstein's phase function with g = 0.85 beside
// what is thrown back evenly (1 / pi, as water_upwelling counts it).
float water_phase(float nu) {
    float d = 1.7225 - 1.7 * nu;
    return 1.0 / PI + 0.6 * 0.2775 / (4.0 * PI) * inversesqrt(d * d * d);
}

// (1 - exp(-x)) / x for any x: rays that rise meet more and more light.
vec3 murk_mean(vec3 x) {
    vec3 safe = mix(x, vec3(1e-3), lessThan(abs(x), vec3(1e-3)));
    return mix((1.0 - exp(-max(safe, -60.0))) / safe, 1.0 - 0.5 * x, lessThan(abs(x), vec3(1e-3)));
}

// Radiance from a path that starts at a depth and rises by `rise` a metre. nu: cosine to the refracted sun.
vec3 water_murk(WaterSun s, float depth_m, float rise, float path_m, float nu) {
    vec3 loss = ocean.loss_per_m;
    vec3 sun = exp(-loss * (depth_m / s.cosine)) * murk_mean(loss * (path_m * (1.0 - rise / s.cosine)));
    vec3 sky = exp(-loss * (depth_m / SKY_COSINE)) * murk_mean(loss * (path_m * (1.0 - rise / SKY_COSINE)));
    return ocean.scattering_per_m * path_m * (s.direct * sun * water_phase(nu)
        + s.diffuse * sky / (SKY_COSINE * PI));
}
