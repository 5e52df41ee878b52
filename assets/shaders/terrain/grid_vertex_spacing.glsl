// Contract "vertex_spacing" of the projected grid: its spacing is a continuous function of the place, which eight bits round too
// coarsely for the layers that fade with it.
#include "generated/terrain_grid.glsl"
#include "terrain/grid_spacing.glsl"

float vertex_spacing(vec3 D, float code) {
    return grid_spacing(D);
}
