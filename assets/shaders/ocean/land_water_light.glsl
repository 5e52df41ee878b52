// Where the light on rivers and lakes is asked, which lie above the sea's level: at what the pixels around a tile's
// corner show.
#include "generated/bindings.glsl"
#include "contract/land_water.glsl"
#include "common/texel.glsl"

layout(std430, binding = FLAG_BUFFER) readonly buffer FlagBuffer { uint flags[]; };
layout(binding = DEPTH_UNIT) uniform sampler2D u_depth;
layout(binding = ATTRIBUTES_UNIT) uniform sampler2D u_attributes;
layout(binding = SURFACE_UNIT) uniform usampler2D u_surface;

// True, and the point that is drawn there, if a tile at this corner shows a river or a lake: of its water, or else of
// ground beside it.
bool land_water_near(ivec2 corner, inout vec3 point) {
    ivec2 size = textureSize(u_surface, 0), tiles = (size + TILE_PX - 1) / TILE_PX;
    uint shown = 0u;
    for (int k = 0; k < 4; ++k) {
        ivec2 tile = corner - ivec2(k & 1, k >> 1);
        bool inside = all(greaterThanEqual(tile, ivec2(0))) && all(lessThan(tile, tiles));
        shown |= inside ? flags[tile.y * tiles.x + tile.x] : 0u;
    }
    bool near = (shown & SURFACE_LAND_WATER) != 0u;
    int best = 0;
    for (int k = 0; k < 9; ++k) {
        ivec2 pixel = clamp(corner * TILE_PX + (ivec2(k % 3, k / 3) - 1) * (TILE_PX - 2) / 2, ivec2(0), size - 1);
        uint surface = texel_at(u_surface, pixel).r;
        int rank = surface == SURFACE_SEA && land_water_at(texel_at(u_attributes, pixel).z) ? 2
            : surface == SURFACE_TERRAIN ? 1 : 0;
        // The middle one before those around.
        rank = rank > 0 && k == 4 ? 2 * rank + 1 : 2 * rank;
        vec3 there = position_from_depth(ndc_of_pixel(vec2(pixel) + 0.5), max(texel_at(u_depth, pixel).r, 1e-30));
        bool better = near && rank > best;
        point = better ? there : point;
        best = better ? rank : best;
    }
    return best > 0;
}
