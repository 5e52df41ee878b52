// Contract "surface_height": the terrain's own height function.
#include "terrain/height.glsl"

float surface_height(vec3 D, float spacing_m) {
    return frame.anchor_height_m + terrain_point(D, spacing_m).dh;
}
