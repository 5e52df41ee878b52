// Which surfaces each tile of 16 x 8 pixels shows: bit n for surface n. A lane a tile.
layout(local_size_x = 64) in;
layout(std430, binding = 0) writeonly buffer FlagBuffer { uint flags[]; };
layout(binding = 0) uniform usampler2D u_surface;
uniform ivec2 u_tiles;

void main() {
    int tile = int(gl_GlobalInvocationID.x);
    ivec2 size = textureSize(u_surface, 0), first = ivec2(tile % u_tiles.x, tile / u_tiles.x) * ivec2(16, 8);
    ivec2 last = min(first + ivec2(16, 8), size);
    uint found = 0u;
    for (int y = first.y; y < last.y; ++y) {
        for (int x = first.x; x < last.x; ++x) found |= 1u << texelFetch(u_surface, ivec2(x, y), 0).r;
    }
    if (tile < u_tiles.x * u_tiles.y) flags[tile] = found;
}
