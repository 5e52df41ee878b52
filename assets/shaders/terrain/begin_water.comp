// Empty lists of tiles.
#include "generated/bindings.glsl"

layout(local_size_x = 1) in;
layout(std430, binding = TILE_BUFFER) writeonly buffer TileBuffer { uint groups[4]; uint tiles[]; } few_list;
layout(std430, binding = WIDE_WATER_BUFFER) writeonly buffer WideBuffer { uint groups[4]; uint tiles[]; } wide_list;
layout(std430, binding = NARROW_WATER_BUFFER) writeonly buffer NarrowBuffer {
    uint groups[4];
    uint tiles[];
} narrow_list;

void main() {
    for (int axis = 0; axis < 3; ++axis) {
        few_list.groups[axis] = axis == 0 ? 0u : 1u;
        wide_list.groups[axis] = axis == 0 ? 0u : 1u;
        narrow_list.groups[axis] = axis == 0 ? 0u : 1u;
    }
}
