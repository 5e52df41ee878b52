// The tiles of each surface as a list behind its indirect dispatch. One workgroup for the whole picture.
#include "common/surfaces.glsl"

layout(local_size_x = 256) in;
layout(std430, binding = 0) readonly buffer FlagBuffer { uint flags[]; };
layout(std430, binding = 1) writeonly buffer TerrainBuffer { uint terrain_groups[4]; uint terrain_tiles[]; };
layout(std430, binding = 2) writeonly buffer SeaBuffer { uint sea_groups[4]; uint sea_tiles[]; };
uniform ivec2 u_tiles;

shared uint s_terrain, s_sea;

void main() {
    if (gl_LocalInvocationIndex == 0u) {
        s_terrain = 0u;
        s_sea = 0u;
    }
    barrier();
    uint count = uint(u_tiles.x * u_tiles.y);
    for (uint tile = gl_LocalInvocationIndex; tile < count; tile += 256u) {
        uint place = tile % uint(u_tiles.x) | tile / uint(u_tiles.x) << 16;
        if ((flags[tile] >> SURFACE_TERRAIN & 1u) != 0u) terrain_tiles[atomicAdd(s_terrain, 1u)] = place;
        if ((flags[tile] >> SURFACE_SEA & 1u) != 0u) sea_tiles[atomicAdd(s_sea, 1u)] = place;
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        terrain_groups[0] = s_terrain;
        terrain_groups[1] = 1u;
        terrain_groups[2] = 1u;
        sea_groups[0] = s_sea;
        sea_groups[1] = 1u;
        sea_groups[2] = 1u;
    }
}
