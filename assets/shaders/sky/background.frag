// Pixels that show no surface: what the air scatters towards the camera. Drawn where depth is 0 (infinitely far).
#include "common/camera.glsl"
#include "contract/sky.glsl"

layout(location = 0) out vec4 o_radiance;

void main() {
    o_radiance = vec4(sky(normalize(view_ray(ndc_of_pixel(gl_FragCoord.xy)))) * frame.hdr_per_radiance, 1.0);
#ifdef PF_FRAG_DEPTH
    gl_FragDepth = 0.0;
#endif
}
