// Radiance of the sun's disc, anti-aliased, energy kept down to discs much smaller than a pixel.
#include "common/constants.glsl"
#include "generated/wavelengths.glsl"

// Limb darkening mu^a (Hestroffer and Magnan 1998); its mean over the disc is 2 / (a + 2). a is 0.397, 0.503 and 0.652
// at 680, 550 and 440 nm, and between them linear in the inverse wavelength, as they found it.
const float LIMB_RED = (1.0 / 550.0 - 1.0 / WAVELENGTHS_NM.r) / (1.0 / 550.0 - 1.0 / 680.0);
const vec3 LIMB_EXPONENTS = vec3(mix(0.503, 0.397, LIMB_RED), 0.503, 0.652);

// sine: of the angle from the centre of the disc; edge: sine of its radius; pixel: angle of a pixel, in radians.
vec3 sun_disc(float sine, float edge, float pixel, vec3 irradiance) {
    float size = edge / pixel;               // radius in pixels
    float drawn = max(size, 0.75);           // no smaller than what pixel centres can catch
    float from_edge = drawn - sine / pixel;  // pixels, positive inside
    float coverage = clamp(from_edge + 0.5, 0.0, 1.0);
    // A ramp one pixel wide on a circle of radius R covers pi (R^2 + 1/12) pixels instead of pi R^2.
    float energy = size * size / (drawn * drawn + 1.0 / 12.0);
    float r = sine / (drawn * pixel);
    // An edge pixel is half outside: the mean of mu^2 over its inner half is about half a pixel's share of the radius.
    float mu2 = max(1.0 - r * r, 0.5 / drawn);
    vec3 limb = pow(vec3(mu2), 0.5 * LIMB_EXPONENTS) * (0.5 * LIMB_EXPONENTS + 1.0);
    limb = mix(vec3(1.0), limb, smoothstep(0.75, 3.0, size));
    return irradiance * limb * (coverage * energy / (PI * edge * edge));
}
