// Contract "waterline" (common/waterline.glsl has the rules): the sea as a plane through the place of the camera, which
// is all that the near plane meets of it.
#include "common/camera.glsl"
#include "generated/ocean.glsl"

float lens_over_water(vec2 ndc) {
    vec3 ray = view_ray(ndc);
    float near = frame.near_m;
    return (dot(ocean.lens.normal, ray) * near + ocean.lens.height_m) / (near * frame.pixel_rad * length(ray));
}

bool lens_in_water(vec2 ndc) {
    return lens_over_water(ndc) < 0.0;
}
