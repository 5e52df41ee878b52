// Which surfaces each tile shows: bit n for surface n; whether any of them is near; and how deep they
// lie. A lane a tile.
#include "generated/bindings.glsl"
#include "generated/frame.glsl"
#include "common/surfaces.glsl"
#include "common/texel.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = FLAG_BUFFER) writeonly buffer FlagBuffer { uint flags[]; };
layout(std430, binding = 1) writeonly buffer DepthBuffer { vec2 depths[]; };   // nearest, farthest, as in gbuffer.depth
layout(binding = 0) uniform usampler2D u_surface;
layout(binding = 1) uniform sampler2D u_depth;
uniform ivec2 u_tiles;

void main() {
    int tile = int(gl_GlobalInvocationID.x);
    ivec2 size = textureSize(u_surface, 0), first = ivec2(tile % u_tiles.x, tile / u_tiles.x) * TILE_PX;
    ivec2 last = min(first + TILE_PX, size);
    uint found = 0u;
    float nearest = 0.0, farthest = 3.0e38;
    for (int y = first.y; y < last.y; ++y) {
        for (int x = first.x; x < last.x; ++x) {
            found |= 1u << texel_at(u_surface, ivec2(x, y)).r;
            float depth = texel_at(u_depth, ivec2(x, y)).r;
            nearest = max(nearest, depth);
            farthest = min(farthest, depth > 0.0 ? depth : 3.0e38);
        }
    }
    // Depth is near / z, and z is no more than the distance, so no near pixel is missed.
    found |= nearest * NEAR_ACROSS_M > frame.near_m * frame.pixel_rad ? SURFACE_NEAR : 0u;
    if (tile >= u_tiles.x * u_tiles.y) return;
    flags[tile] = found;
    depths[tile] = vec2(nearest, min(farthest, nearest));
}
