#include "ocean/paper/grid.glsl"
#define PAPER_LOWEST (planet.sea_level_m - sea_grid.reach_m)
#define PAPER_HIGHEST (planet.sea_level_m + sea_grid.reach_m)
#include "common/paper/cull.glsl"
