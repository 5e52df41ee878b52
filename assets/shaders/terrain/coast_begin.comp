// Empty lists of pixels, and of tiles.
#define COAST_SECOND
#include "terrain/coast_list.glsl"

layout(local_size_x = 1) in;

void main() {
    for (int axis = 0; axis < 3; ++axis) {
        coast_list.groups[axis] = axis == 0 ? 0u : 1u;
        coast_land.groups[axis] = axis == 0 ? 0u : 1u;
        coast_more.groups[axis] = axis == 0 ? 0u : 1u;
    }
    coast_list.count = 0u;
    coast_land.count = 0u;
}
