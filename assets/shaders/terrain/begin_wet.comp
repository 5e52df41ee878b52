// Empty lists of dry and of wet tiles.
#include "terrain/wet_lists.glsl"

layout(local_size_x = 1) in;

void main() {
    for (int axis = 0; axis < 3; ++axis) {
        uint groups = axis == 0 ? 0u : 1u;
        dry_list.groups[axis] = groups;
        wet_list.groups[axis] = groups;
        near_dry_list.groups[axis] = groups;
        near_wet_list.groups[axis] = groups;
    }
}
