// Waves shorter than the shortest of the sea's own, from there down to 6 cm, as far as a pixel shows them: octaves of
// noise that drift with the wind. Their slopes are taken out of the variance of what is too small to see, so the sea
// stays as rough as it is.
#include "ocean/look/pixel.glsl"

const float RIPPLE_SLOPE = 0.498;   // rms of gradient noise's derivative along one axis, by the cell

void sea_ripples(inout SeaPixel p) {
    float footprint = p.footprint_m * inversesqrt(max(dot(p.view, p.zenith), 0.05));
    int k = ocean.ripple_octave;
    float cell_m = NESTED_BASE_M * exp2(float(k));
    // Equal variance in each octave, as of a spectrum that falls with the wavelength's fourth power.
    vec3 each = p.slopes.variance * ocean.ripple_share;
    vec2 deviation = sqrt(max(each.xy, 0.0)) / RIPPLE_SLOPE;
    vec2 slope = vec2(0.0);
    float gone = 0.0;
    while (k >= 0) {
        float seen = clamp(1.5 - 2.0 * footprint / cell_m, 0.0, 1.0);
        if (seen <= 0.0) break;
        ivec3 cell;
        vec3 fraction;
        float frequency;
        NestedAnchor anchor = ocean.drifting[(k + 1) & 1];
        nested_place(anchor.cell, anchor.fraction, p.D, k, cell, fraction, frequency);
        slope += seen * (gradient_noise(cell, fraction).xyz * p.level).xy;
        gone += seen * seen;
        cell_m *= 0.5;
        --k;
    }
    p.slopes.mean += deviation * slope;
    p.slopes.variance -= each * gone;
}
