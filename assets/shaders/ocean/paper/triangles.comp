#include "ocean/paper/grid.glsl"
#include "common/paper/triangles.glsl"
