// Contract "waterline" (common/waterline.glsl has the rules): the sea as a plane through the place of the camera, which is
// all that the near plane meets of it.
#include "common/camera.glsl"
#include "generated/ocean.glsl"

bool lens_in_water(vec2 ndc) {
    return dot(ocean.lens.xyz, view_ray(ndc)) * frame.camera_offset.w + ocean.lens.w < 0.0;
}
