#include "terrain/paper/grid.glsl"
#define PAPER_LOWEST planet.radii.z
#define PAPER_HIGHEST planet.radii.y
#include "common/paper/cull.glsl"
