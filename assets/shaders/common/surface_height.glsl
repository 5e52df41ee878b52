// Contract "surface_height", default: no ground.
//
//   float surface_height(vec3 D, float spacing_m)   height of the solid ground above the reference sphere, metres, at
//   foot offset D
//                                                   from the anchor; detail finer than spacing_m may be left out
float surface_height(vec3 D, float spacing_m) {
    return -1.0e9;
}
