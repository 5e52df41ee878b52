// Contract "waterline", default: no water.
//
//   bool lens_in_water(vec2 ndc)     whether the near plane lies in water at a point of the screen: what is seen there is seen through
//                                    water, and the surface of the sea from below

bool lens_in_water(vec2 ndc) {
    return false;
}
