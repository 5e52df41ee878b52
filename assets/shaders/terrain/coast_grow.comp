// Adds the tiles into which a lake or an island goes on that the height function found in a tile beside: the meshes
// show nothing of it there, and it would end along the tile's border. A lane a tile.
#include "generated/bindings.glsl"
#include "common/surfaces.glsl"
#include "common/texel.glsl"

layout(local_size_x = 64) in;
layout(binding = SURFACE_UNIT) uniform usampler2D u_surface;
layout(std430, binding = FLAG_BUFFER) buffer FlagBuffer { uint flags[]; };
layout(std430, binding = TERRAIN_TILES_BUFFER) buffer TerrainBuffer { uint terrain_groups[4]; uint terrain_tiles[]; };
layout(std430, binding = SEA_TILES_BUFFER) buffer SeaBuffer { uint sea_groups[4]; uint sea_tiles[]; };
layout(std430, binding = COAST_MORE_BUFFER) buffer MoreBuffer { uint more_groups[4]; uint more_tiles[]; };
uniform ivec2 u_tiles;

const uint LAND = 1u << SURFACE_TERRAIN, SEA = 1u << SURFACE_SEA;

uint seen(ivec2 pixel) {
    ivec2 last = textureSize(u_surface, 0) - 1;
    return 1u << texel_at(u_surface, clamp(pixel, ivec2(0), last)).r & (LAND | SEA);
}

void main() {
    int tile = int(gl_GlobalInvocationID.x);
    bool there = tile < u_tiles.x * u_tiles.y;
    uint own = there ? flags[tile] : SURFACE_ASKED;
    ivec2 at = ivec2(tile % u_tiles.x, tile / u_tiles.x), first = at * TILE_PX;
    bool meets = false;
    int turns = (own & SURFACE_ASKED) == 0u && (own & (LAND | SEA)) != 0u ? TILE_PX.x : 0;
    for (int k = 0; k < turns; ++k) {
        ivec2 low = first + ivec2(k, 0), left = first + ivec2(0, k / 2), high = low + ivec2(0, TILE_PX.y - 1),
            right = left + ivec2(TILE_PX.x - 1, 0);
        meets = meets || (seen(low) | seen(low - ivec2(0, 1))) == (LAND | SEA)
            || (seen(high) | seen(high + ivec2(0, 1))) == (LAND | SEA)
            || (seen(left) | seen(left - ivec2(1, 0))) == (LAND | SEA)
                || (seen(right) | seen(right + ivec2(1, 0))) == (LAND | SEA);
    }
    if (!meets) return;
    uint place = uint(at.x) | uint(at.y) << 16;
    atomicOr(flags[tile], SURFACE_ASKED);
    more_tiles[atomicAdd(more_groups[0], 1u)] = place;
    if ((own & LAND) == 0u) terrain_tiles[atomicAdd(terrain_groups[0], 1u)] = place;
    if ((own & SEA) == 0u) sea_tiles[atomicAdd(sea_groups[0], 1u)] = place;
}
