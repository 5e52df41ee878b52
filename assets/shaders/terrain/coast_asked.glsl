// The pixel that a lane asks about: from a list (terrain/coast_list.glsl), or with COAST_TILES from a tile of which
// each is asked. With COAST_STEP 2 the first of a block.
#include "generated/bindings.glsl"
#include "terrain/coast_list.glsl"
#include "common/spread.glsl"
#include "common/surfaces.glsl"

#ifdef COAST_TILES
#if COAST_STEP == 2
layout(local_size_x = HALF_TILE_WIDTH, local_size_y = HALF_TILE_HEIGHT) in;
#else
layout(local_size_x = TILE_WIDTH, local_size_y = TILE_HEIGHT) in;
#endif
layout(std430, binding = TILE_BUFFER) readonly buffer TileBuffer {
    uint tile_groups[4];
    uint tiles[];
};

bool coast_asked(out ivec2 pixel) {
    uint tile = tiles[spread_tiles()];
    pixel = ivec2(tile & 0xffffu, tile >> 16) * TILE_PX + COAST_STEP * ivec2(gl_LocalInvocationID.xy);
    return all(lessThan(pixel, textureSize(u_surface, 0)));
}
#else
layout(local_size_x = 64) in;

bool coast_asked(out ivec2 pixel) {
    uint index = spread_blocks(8u) * COAST_GROUP + gl_LocalInvocationID.x;
    bool there = index < coast_list.count;
    pixel = coast_listed(coast_list.pixels[there ? index : 0u]);
    return there;
}
#endif
