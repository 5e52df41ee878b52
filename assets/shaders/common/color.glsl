// Luminance, exposure and display encoding. Twin: systems/composite/photometry.py; docs/exposure.md explains it.

#include "generated/wavelengths.glsl"

// cd m^-2 per W m^-2 sr^-1 nm^-1 for light of the sun's colour: 133.1 klx over the irradiance of sunlight.
const vec3 LUMINANCE_PER_RADIANCE = vec3(133100.0) / SUNLIGHT;
const vec3 LUMINANCE_WEIGHTS = vec3(0.2126, 0.7152, 0.0722);
const float SATURATION = 1.2;  // cd m^-2 that expose to 1 at EV100 0

// Light at three wavelengths, at least 0 and in any unit in which sunlight is 1, to linear sRGB, below 0 where a
// display cannot show it: by what there is at them, and where that is not enough by the geometric means of two, which
// are near what lies between. Twin: engine/display.py.
vec3 display_color(vec3 light) {
#ifdef DISPLAY_BETWEEN
    vec3 root = sqrt(light);
    return DISPLAY * light + DISPLAY_BETWEEN * (root * root.gbr);
#else
    return DISPLAY * light;
#endif
}

vec3 lit(vec3 radiance) {
    return clamp(radiance, 0.0, 1e30) * LUMINANCE_PER_RADIANCE;   // infinity times 0 would be no number
}

// Linear sRGB in cd m^-2, never negative.
vec3 display_light(vec3 radiance) {
    return max(display_color(lit(radiance)), 0.0);
}

float luminance_of_radiance(vec3 radiance) {
    return max(dot(display_color(lit(radiance)), LUMINANCE_WEIGHTS), 0.0);
}

vec3 srgb_encode(vec3 linear) {
    vec3 x = clamp(linear, 0.0, 1.0);
    return mix(12.92 * x, 1.055 * pow(max(x, vec3(1e-9)), vec3(1.0 / 2.4)) - 0.055, greaterThan(x, vec3(0.0031308)));
}
