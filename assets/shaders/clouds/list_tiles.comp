// The tiles with cloud as two lists behind their indirect dispatches: without cirrus from the first place on, with it
// from the last one back. One workgroup for the whole picture.
#include "generated/bindings.glsl"
layout(local_size_x = 256) in;
layout(std430, binding = FLAG_BUFFER) readonly buffer FlagBuffer { uint flags[]; };
layout(std430, binding = 1) writeonly buffer TileBuffer { uint groups[8]; uint tiles[]; };
layout(location = 0) uniform ivec2 u_tiles;

shared uint s_count[2];

void main() {
    if (gl_LocalInvocationIndex < 2u) s_count[gl_LocalInvocationIndex] = 0u;
    barrier();
    uint count = uint(u_tiles.x * u_tiles.y), width = uint(u_tiles.x), last = uint(tiles.length()) - 1u;
    for (uint tile = gl_LocalInvocationIndex; tile < count; tile += 256u) {
        uint place = tile % width | (tile / width) << 16;
        if (flags[tile] == 2u) tiles[atomicAdd(s_count[0], 1u)] = place;
        if (flags[tile] == 3u) tiles[last - atomicAdd(s_count[1], 1u)] = place;
    }
    barrier();
    if (gl_LocalInvocationIndex < 2u) {
        groups[4u * gl_LocalInvocationIndex] = s_count[gl_LocalInvocationIndex];
        groups[4u * gl_LocalInvocationIndex + 1u] = 1u;
        groups[4u * gl_LocalInvocationIndex + 2u] = 1u;
    }
}
