#include "terrain/paper/grid.glsl"
#define PAPER_LOWEST planet.lowest_m
#define PAPER_HIGHEST planet.highest_m
#include "common/paper/cull.glsl"
