// Tiles of the picture that a river or a lake may show in, by some of their pixels. A lane a tile.
#include "terrain/water_place.glsl"
#include "terrain/waters.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = FLAG_BUFFER) buffer FlagBuffer { uint flags[]; };
layout(std430, binding = TILE_BUFFER) buffer TileBuffer { uint tile_groups[4]; uint tiles[]; };
uniform ivec2 u_tiles;
uniform float u_reach_m;   // all places know of water this far away

const int LOOKS = 9;
// Places between those are no further from their middle than so many times as far as these; and the warp that bends
// lines stretches lengths.
const float WITHIN = 1.3, STRETCHED = 1.6;

void main() {
    int tile = int(gl_GlobalInvocationID.x);
    bool there = tile < u_tiles.x * u_tiles.y;
    uint shown = there ? flags[tile] : 0u;
    ivec2 at = ivec2(tile % u_tiles.x, tile / u_tiles.x), first = at * TILE_PX;
    int looks = (shown & (1u << SURFACE_TERRAIN | 1u << SURFACE_SEA)) != 0u ? LOOKS : 0;
    vec3 low = vec3(3.0e38), high = vec3(-3.0e38);
    for (int k = 0; k < looks; ++k) {
        WaterPlace place = water_place(first + ivec2(k % 3, k / 3) * (TILE_PX - 1) / 2);
        low = place.open ? min(low, place.D) : low;
        high = place.open ? max(high, place.D) : high;
    }
    bool any_place = low.x <= high.x;
    vec3 middle = any_place ? 0.5 * (low + high) : vec3(0.0);
    float radius = any_place ? WITHIN * STRETCHED * 0.5 * length(high - low) : 0.0;
    // The middle of a wide tile does not know of all lines that may pass it.
    bool wide = radius > u_reach_m;
    RiverPlace p = river_place(middle);
    if (!any_place || wide) p.lines.y = 0;
    bool near = any_place && (wide || water_within(p, radius));
    if (near) {
        flags[tile] = shown | SURFACE_WATER_ASKED;
        tiles[atomicAdd(tile_groups[0], 1u)] = uint(at.x) | uint(at.y) << 16;
    }
}
