// The tiles of each kind of sea as a list behind its indirect dispatch. One workgroup for the whole picture.
layout(local_size_x = 256) in;
layout(std430, binding = 0) readonly buffer FlagBuffer { uint flags[]; };
layout(std430, binding = 1) writeonly buffer OpenBuffer { uint open_groups[4]; uint open_tiles[]; };
layout(std430, binding = 2) writeonly buffer RichBuffer { uint rich_groups[4]; uint rich_tiles[]; };
layout(std430, binding = 3) writeonly buffer BelowBuffer { uint below_groups[4]; uint below_tiles[]; };
uniform ivec2 u_tiles;

shared uint s_open, s_rich, s_below;

void main() {
    if (gl_LocalInvocationIndex == 0u) {
        s_open = 0u;
        s_rich = 0u;
        s_below = 0u;
    }
    barrier();
    uint count = uint(u_tiles.x * u_tiles.y);
    for (uint tile = gl_LocalInvocationIndex; tile < count; tile += 256u) {
        uint place = tile % uint(u_tiles.x) | tile / uint(u_tiles.x) << 16, found = flags[tile];
        if ((found & 1u) != 0u) open_tiles[atomicAdd(s_open, 1u)] = place;
        if ((found & 2u) != 0u) rich_tiles[atomicAdd(s_rich, 1u)] = place;
        if ((found & 4u) != 0u) below_tiles[atomicAdd(s_below, 1u)] = place;
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u) {
        open_groups[0] = s_open;
        open_groups[1] = 1u;
        open_groups[2] = 1u;
        rich_groups[0] = s_rich;
        rich_groups[1] = 1u;
        rich_groups[2] = 1u;
        below_groups[0] = s_below;
        below_groups[1] = 1u;
        below_groups[2] = 1u;
    }
}
