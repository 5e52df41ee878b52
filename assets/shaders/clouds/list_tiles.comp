// The tiles with cloud as a list behind its indirect dispatch. One workgroup for the whole picture.
layout(local_size_x = 256) in;
layout(std430, binding = 0) readonly buffer FlagBuffer { uint flags[]; };
layout(std430, binding = 1) writeonly buffer TileBuffer { uint groups[4]; uint tiles[]; };
layout(location = 0) uniform ivec2 u_tiles;

shared uint s_count;

void main() {
    if (gl_LocalInvocationIndex == 0u) s_count = 0u;
    barrier();
    uint count = uint(u_tiles.x * u_tiles.y), width = uint(u_tiles.x);
    for (uint tile = gl_LocalInvocationIndex; tile < count; tile += 256u) {
        if (flags[tile] == 2u) tiles[atomicAdd(s_count, 1u)] = tile % width | (tile / width) << 16;
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        groups[0] = s_count;
        groups[1] = 1u;
        groups[2] = 1u;
    }
}
