// The Milky Way behind the stars: one look-up into the map, in galactic axes.
#include "common/camera.glsl"
#include "common/octahedral.glsl"
#ifndef STARS_CLEAR
#include "contract/air.glsl"
#endif
#include "sky/behind_planets.glsl"

layout(binding = 0) uniform sampler2D u_galaxy;
layout(location = 0) uniform mat3 u_galactic_axes;  // planet to galactic
layout(location = 1) uniform float u_brightness;
in vec2 v_ndc;
layout(location = 0) out vec4 o_radiance;

// Brightest clouds: 600 stars of magnitude 10 a square degree, each 3.63e-15 W m^-2 nm^-1 (20.8 mag per square second).
const float BRIGHTEST = 600.0 * 1.19e-11;

void main() {
    vec3 direction = normalize(view_ray(v_ndc));
    vec3 light = textureLod(u_galaxy, oct_encode(u_galactic_axes * direction) * 0.5 + 0.5, 0.0).rgb;
#ifndef STARS_CLEAR
    light *= air_to_space(vec3(0.0), direction);
#endif
    light *= past_planets();
    o_radiance = vec4(light * (BRIGHTEST * u_brightness * frame.hdr_per_radiance), 0.0);
#ifdef PF_FRAG_DEPTH
    gl_FragDepth = 0.0;
#endif
}
