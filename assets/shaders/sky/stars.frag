#include "common/constants.glsl"
#include "sky/behind_planets.glsl"

layout(location = 2) uniform float u_limit;
flat in vec2 v_center;
flat in vec3 v_light;
layout(location = 0) out vec4 o_radiance;

// Width of a star in pixels. The sum of the spot over pixel centres changes by 2 exp(-2 pi^2 s^2) with its place in the
// pixel: 1.3e-4 at 0.7, so nothing twinkles when the camera turns.
const float SPREAD = 0.7;

void main() {
    vec2 from_center = gl_FragCoord.xy - v_center;
    float spot = exp(dot(from_center, from_center) * (-0.5 / (SPREAD * SPREAD))) / (TWO_PI * SPREAD * SPREAD);
    o_radiance = vec4(min(v_light * (spot * past_planets()), vec3(u_limit)), 0.0);
#ifdef PF_FRAG_DEPTH
    gl_FragDepth = 0.0;
#endif
}
