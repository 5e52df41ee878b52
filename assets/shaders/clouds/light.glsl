// Light in clouds: what a place scatters towards the camera for the optical depth between it and the sun.
//
// Light that was scattered once keeps the droplets' phase function. Light that was scattered more often spreads as diffusion
// does in a scattering medium: isotropic, and falling with depth as 1 / (1 + 3/4 (1 - g) depth) instead of exponentially
// (two-stream approximation, Bohren 1987), which is why the undersides of clouds are grey and not black. Thin clouds keep little
// of it: a layer of depth d throws back 3/4 (1 - g) d / (1 + 3/4 (1 - g) d) (the same, in Eddington's form), so that from space
// thick weather is white and thin weather grey.

#include "common/safe.glsl"

const float CLOUD_LENT = 0.3;      // of the diffuse light: what a thin rim has from the cloud beside it
const float CLOUD_DIFFUSE = 3.0;   // times the sun's irradiance: fluence of the diffuse light under the sunlit side

float cloud_henyey_greenstein(float nu, float g) {
    float base = (1.0 - abs(g)) * (1.0 - abs(g)) + 2.0 * abs(g) * (1.0 - sign_nonzero(g) * nu);
    return (1.0 - g * g) / (4.0 * PF_PI * base * sqrt(base));
}

// x: of light scattered once, per unit of depth and of the sun's irradiance; y: of light scattered twice to a few times, whose
// forward peak is wider.
vec2 cloud_phases(float nu, float g) {
    return vec2(mix(cloud_henyey_greenstein(nu, g), cloud_henyey_greenstein(nu, -0.3), 0.1), cloud_henyey_greenstein(nu, 0.5 * g));
}

// depth: towards the sun; whole: vertical, of all the cloud around the place.
float cloud_sun_source(vec2 phases, float g, float depth, float whole) {
    float once = phases.x * exp(-depth);
    float few = 0.45 * phases.y * exp(-0.25 * depth);
    // Next to the lit side part of it is still on its way in, and falls off faster: slopes that face the sun are brighter.
    float diffuse = CLOUD_DIFFUSE / (4.0 * PF_PI) * (0.55 * exp(-0.3 * depth) + 0.45 / (1.0 + 0.75 * (1.0 - g) * depth));
    float kept = 0.75 * (1.0 - g) * whole;
    return once + few + diffuse * mix(CLOUD_LENT, 1.0, kept / (1.0 + kept));
}

// The same for the light of an even sky of radiance 1, under an optical depth measured upwards: white clouds throw four fifths of
// it back, and some of it comes in from the sides wherever a place lies.
float cloud_sky_source(float g, float depth) {
    return 0.72 / (1.0 + 0.75 * (1.0 - g) * depth) + 0.1;
}
