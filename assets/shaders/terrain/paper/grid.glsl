// The projected grid of the ground.
#include "generated/frame.glsl"
#include "generated/planet.glsl"
#include "generated/paper_grid.glsl"
#include "common/paper/places.glsl"
