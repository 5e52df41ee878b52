// An empty list of tiles.
#include "generated/bindings.glsl"

layout(local_size_x = 1) in;
layout(std430, binding = TILE_BUFFER) writeonly buffer TileBuffer { uint tile_groups[4]; uint tiles[]; };

void main() {
    tile_groups[0] = 0u;
    tile_groups[1] = 1u;
    tile_groups[2] = 1u;
}
