// The tiles of each surface, of the ground near and far ones, as a list behind its indirect dispatch. One workgroup for
// the whole picture.
#include "generated/bindings.glsl"
#include "common/surfaces.glsl"

layout(local_size_x = 256) in;
layout(std430, binding = FLAG_BUFFER) buffer FlagBuffer { uint flags[]; };
layout(std430, binding = TERRAIN_TILES_BUFFER) writeonly buffer TerrainBuffer {
    uint terrain_groups[4];
    uint terrain_tiles[];
};
layout(std430, binding = SEA_TILES_BUFFER) writeonly buffer SeaBuffer {
    uint sea_groups[4];
    uint sea_tiles[];
};
layout(std430, binding = 3) writeonly buffer CoastBuffer { uint coast_groups[4]; uint coast_tiles[]; };
layout(std430, binding = 4) writeonly buffer NearBuffer { uint near_groups[4]; uint near_tiles[]; };
uniform ivec2 u_tiles;

shared uint s_terrain, s_sea, s_coast, s_near;

const uint BOTH = 1u << SURFACE_TERRAIN | 1u << SURFACE_SEA;

uint around(uint tile) {
    ivec2 here = ivec2(tile % uint(u_tiles.x), tile / uint(u_tiles.x));
    uint found = 0u;
    for (int y = max(here.y - 1, 0); y <= min(here.y + 1, u_tiles.y - 1); ++y) {
        for (int x = max(here.x - 1, 0); x <= min(here.x + 1, u_tiles.x - 1); ++x) found |= flags[y * u_tiles.x + x];
    }
    return found;
}

void main() {
    if (gl_LocalInvocationIndex == 0u) {
        s_terrain = 0u;
        s_sea = 0u;
        s_coast = 0u;
        s_near = 0u;
    }
    barrier();
    uint count = uint(u_tiles.x * u_tiles.y);
    for (uint tile = gl_LocalInvocationIndex; tile < count; tile += 256u) {
        uint place = tile % uint(u_tiles.x) | tile / uint(u_tiles.x) << 16;
        uint own = flags[tile] & BOTH;
        // Where land and water meet the line between them is drawn anew, pixel by pixel: either may get pixels. So is
        // land along the limb, where a coarse triangle may stand before the sea.
        uint near = around(tile);
        bool coast = own != 0u && (near >> SURFACE_TERRAIN & 1u) != 0u
            && (near & (1u << SURFACE_SEA | 1u << SURFACE_NONE)) != 0u;
        if (coast) coast_tiles[atomicAdd(s_coast, 1u)] = place;
        if (coast) atomicOr(flags[tile], SURFACE_ASKED);
        bool terrain = coast || (own >> SURFACE_TERRAIN & 1u) != 0u, close = (flags[tile] & SURFACE_NEAR) != 0u;
        if (terrain && close) near_tiles[atomicAdd(s_near, 1u)] = place;
        if (terrain && !close) terrain_tiles[atomicAdd(s_terrain, 1u)] = place;
        if (coast || (own >> SURFACE_SEA & 1u) != 0u) sea_tiles[atomicAdd(s_sea, 1u)] = place;
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        terrain_groups[0] = s_terrain;
        terrain_groups[1] = 1u;
        terrain_groups[2] = 1u;
        near_groups[0] = s_near;
        near_groups[1] = 1u;
        near_groups[2] = 1u;
        coast_groups[0] = s_coast;
        coast_groups[1] = 1u;
        coast_groups[2] = 1u;
        sea_groups[0] = s_sea;
        sea_groups[1] = 1u;
        sea_groups[2] = 1u;
    }
}
