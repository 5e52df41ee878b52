// The projected grid of the sea.
#include "generated/frame.glsl"
#include "generated/planet.glsl"
#include "generated/sea_grid.glsl"
#define paper_grid sea_grid
#include "common/paper/places.glsl"
