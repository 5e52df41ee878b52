// Contract "surface_height" of the projected grid's paper mode.
#include "generated/frame.glsl"
#include "terrain/paper/ground.glsl"

float surface_height(vec3 D, float spacing_m) {
    return frame.anchor_height_m + paper_dh(D);
}
