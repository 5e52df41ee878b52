// Contract "waterline", default: no water.
//
//   bool lens_in_water(vec2 ndc)     whether the near plane lies in water at a point of the screen: what is seen there
//   is seen through
//                                    water, and the surface of the sea from below
//   float lens_over_water(vec2 ndc)  how far over the water's line that point is, in pixels; large far away

bool lens_in_water(vec2 ndc) {
    return false;
}

float lens_over_water(vec2 ndc) {
    return 1e9;
}
