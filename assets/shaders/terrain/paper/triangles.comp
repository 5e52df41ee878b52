#include "terrain/paper/grid.glsl"
#include "common/paper/triangles.glsl"
