// Pixels that show no surface: what the air scatters towards the camera. Drawn where depth is 0 (infinitely far).
#include "common/camera.glsl"
#include "contract/sky.glsl"

in vec2 v_ndc;
layout(location = 0) out vec4 o_radiance;

void main() {
    o_radiance = vec4(sky(normalize(view_ray(v_ndc))) * frame.scale.x, 1.0);
#ifdef PF_FRAG_DEPTH
    gl_FragDepth = 0.0;
#endif
}
