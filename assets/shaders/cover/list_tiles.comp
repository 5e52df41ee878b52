// Tiles that show trees, as a list behind its indirect dispatch. One workgroup.
#include "generated/bindings.glsl"
#include "common/surfaces.glsl"

layout(local_size_x = 256) in;
layout(std430, binding = FLAG_BUFFER) readonly buffer FlagBuffer { uint flags[]; };
layout(std430, binding = 1) writeonly buffer CoverBuffer { uint cover_groups[4]; uint cover_tiles[]; };
uniform ivec2 u_tiles;

shared uint s_count;

void main() {
    if (gl_LocalInvocationIndex == 0u) s_count = 0u;
    barrier();
    uint count = uint(u_tiles.x * u_tiles.y);
    for (uint tile = gl_LocalInvocationIndex; tile < count; tile += 256u) {
        if ((flags[tile] >> SURFACE_COVER & 1u) != 0u) {
            cover_tiles[atomicAdd(s_count, 1u)] = tile % uint(u_tiles.x) | tile / uint(u_tiles.x) << 16;
        }
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        cover_groups[0] = s_count;
        cover_groups[1] = 1u;
        cover_groups[2] = 1u;
    }
}
