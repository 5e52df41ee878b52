#include "common/camera.glsl"
#include "contract/air.glsl"
#include "sky/sun_disc.glsl"
#include "sky/behind_planets.glsl"

layout(location = 0) uniform float u_limit;  // largest value that the target can hold
in vec2 v_slope;
layout(location = 0) out vec4 o_radiance;

void main() {
    vec2 ndc = ndc_of_pixel(gl_FragCoord.xy);
    vec3 direction = normalize(view_ray(ndc));
    float slope2 = dot(v_slope, v_slope);
    float sine = sqrt(slope2 / (1.0 + slope2));
    // Off the centre of the picture a pixel is smaller: by the cosine across and its square along.
    float cosine = dot(direction, frame.camera_forward);
    float pixel = frame.pixel_rad * cosine * sqrt(cosine);
    vec3 radiance = sun_disc(sine, sin(frame.sun_radius_rad), pixel, frame.sun_irradiance);
    radiance *= air_to_space(vec3(0.0), direction) * past_planets();
    o_radiance = vec4(min(radiance * frame.hdr_per_radiance, vec3(u_limit)), 0.0);
#ifdef PF_FRAG_DEPTH
    gl_FragDepth = 0.0;
#endif
}
