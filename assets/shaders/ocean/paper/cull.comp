#include "ocean/paper/grid.glsl"
#define PAPER_LOWEST (planet.sea.x - sea_grid.sea.x)
#define PAPER_HIGHEST (planet.sea.x + sea_grid.sea.x)
#include "common/paper/cull.glsl"
