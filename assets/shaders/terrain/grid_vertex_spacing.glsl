// Contract "vertex_spacing" of the projected grid: its spacing is a continuous function of the place, which eight bits
// round too coarsely for the layers that fade with it. While the normals of one selection fade into those of the next,
// so does the spacing: else layers would be missing, or twice there. A layer's share goes by wavelength over spacing:
// the mean of that.
#include "generated/terrain_grid.glsl"
#include "terrain/grid_spacing.glsl"

float vertex_spacing(vec3 D, float code) {
    float now = grid_spacing(D, terrain_grid.spacing);
    float before = grid_spacing(D + terrain_grid.moved_m, terrain_grid.faded);
    return 1.0 / mix(1.0 / now, 1.0 / before, terrain_grid.faded_share);
}
