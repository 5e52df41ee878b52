// Luminance, exposure and display encoding. Twin: systems/composite/photometry.py; explained in docs/exposure.md.

// cd m^-2 per W m^-2 sr^-1 nm^-1 at 680, 550, 440 nm for light of the sun's colour: 133.1 klx over the irradiance of
// sunlight.
const vec3 LUMINANCE_PER_RADIANCE = vec3(133100.0) / vec3(1.474, 1.8504, 1.91198);
const vec3 LUMINANCE_WEIGHTS = vec3(0.2126, 0.7152, 0.0722);
const float SATURATION = 1.2;  // cd m^-2 that expose to 1 at EV100 0

// Light of three wavelengths to linear sRGB: its red is seen around 610 nm, between 680 and 550. Rows add up to 1.
const mat3 DISPLAY = mat3(0.67, 0.0, 0.0, 0.42, 0.965, 0.0, -0.09, 0.035, 1.0);

// Linear sRGB in cd m^-2, never negative.
vec3 display_light(vec3 radiance) {
    return max(DISPLAY * (min(radiance, 1e30) * LUMINANCE_PER_RADIANCE), 0.0);   // infinity times 0 would be no number
}

float luminance_of_radiance(vec3 radiance) {
    return dot(radiance * LUMINANCE_PER_RADIANCE, LUMINANCE_WEIGHTS * DISPLAY);
}

vec3 srgb_encode(vec3 linear) {
    vec3 x = clamp(linear, 0.0, 1.0);
    return mix(12.92 * x, 1.055 * pow(max(x, vec3(1e-9)), vec3(1.0 / 2.4)) - 0.055, greaterThan(x, vec3(0.0031308)));
}
