// What each tile's sea needs: bit 0 the plain sea, 1 also bed, foam or ice, 2 the surface from below. A lane a tile.
#include "common/camera.glsl"
#include "common/surfaces.glsl"
#include "generated/ocean.glsl"
#include "contract/waterline.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = 0) writeonly buffer FlagBuffer { uint flags[]; };
layout(binding = 0) uniform sampler2D u_depth;
layout(binding = 1) uniform sampler2D u_attributes;
layout(binding = 2) uniform usampler2D u_surface;
uniform ivec2 u_tiles;

void main() {
    int tile = int(gl_GlobalInvocationID.x);
    ivec2 size = textureSize(u_surface, 0), first = ivec2(tile % u_tiles.x, tile / u_tiles.x) * ivec2(16, 8);
    ivec2 last = min(first + ivec2(16, 8), size);
    float shallowest = 2.0, highest_sine = 0.0;
    bool any_sea = false, above = false, below = false;
    float limit = ocean.loss.w / (ocean.loss.w + 16.0);
    for (int y = first.y; y < last.y; ++y) {
        for (int x = first.x; x < last.x; ++x) {
            bool sea = texelFetch(u_surface, ivec2(x, y), 0).r == SURFACE_SEA;
            vec2 bytes = texelFetch(u_attributes, ivec2(x, y), 0).rg;
            shallowest = min(shallowest, sea ? (bytes.x * 256.0 + bytes.y) * (255.0 / 65535.0) : 2.0);
            any_sea = any_sea || sea;
        }
    }
    // Ice and the waterline, by the tile's corners.
    for (int corner = 0; corner < 4; ++corner) {
        ivec2 pixel = clamp(first + ivec2(corner & 1, corner >> 1) * ivec2(15, 7), ivec2(0), size - 1);
        vec2 ndc = ndc_of_pixel(vec2(pixel) + 0.5);
        bool wet = lens_in_water(ndc);
        above = above || !wet;
        below = below || wet;
        float depth = texelFetch(u_depth, pixel, 0).r;
        highest_sine = max(highest_sine, depth > 0.0 ? abs(up_at(position_from_depth(ndc, depth)).z) : 1.0);
    }
    bool rich = shallowest < limit || highest_sine * 1.02 + 0.12 > ocean.water.y;
    uint found = (above ? (rich ? 2u : 1u) : 0u) | (below ? 4u : 0u);
    if (tile < u_tiles.x * u_tiles.y) flags[tile] = any_sea ? found : 0u;
}
