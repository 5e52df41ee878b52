// Henyey and Greenstein 1941, 1/sr; 1 + g^2 - 2 g nu without its cancellation near the peak.
#include "common/safe.glsl"

float cloud_phase(float nu, float g) {
    float size = abs(g), near = 1.0 - size;
    float base = near * near + 2.0 * size * (1.0 - sign_nonzero(g) * nu);
    return (1.0 - g * g) / (4.0 * PI * base * sqrt(base));
}
