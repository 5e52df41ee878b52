// Contract "waterline" (common/waterline.glsl has the rules): the sea as a plane through the place of the camera, which
// is all that the near plane meets of it.
#include "common/camera.glsl"
#include "generated/ocean.glsl"

float lens_over_water(vec2 ndc) {
    vec3 ray = view_ray(ndc);
    float near = frame.camera_offset.w;
    return (dot(ocean.lens.xyz, ray) * near + ocean.lens.w) / (near * frame.clock.w * length(ray));
}

bool lens_in_water(vec2 ndc) {
    return lens_over_water(ndc) < 0.0;
}
