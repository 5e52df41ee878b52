// Sorts tiles with ground by whether water changes any of it (contract "water", and rivers), and by whether crowns of a
// forest or things that stand on the ground may show: the others are shaded without. A lane a tile. For water most are
// settled by the depths between which all of it lies; in the rest each pixel is looked at.
#include "generated/bindings.glsl"
#include "common/camera.glsl"
#include "common/surfaces.glsl"
#include "common/spacing_code.glsl"
#include "common/spread.glsl"
#include "common/texel.glsl"
#include "terrain/wet_lists.glsl"
#include "contract/land_water.glsl"
#include "contract/water.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = 7) readonly buffer DepthBuffer { vec2 depths[]; };
layout(binding = DEPTH_UNIT) uniform sampler2D u_depth;
layout(binding = ATTRIBUTES_UNIT) uniform sampler2D u_attributes;
layout(binding = SURFACE_UNIT) uniform usampler2D u_surface;
layout(std430, binding = 4) readonly buffer FlagBuffer { uint flags[]; };
uniform ivec2 u_tiles;
uniform vec2 u_crowns_m;   // distances between which crowns of a forest may show

const float HAIR_M = 0.05;       // more than rounding does to a height
// pixels narrower than this show no triangle whose chord sinks below the sphere by metres
const float COARSE_M = 100.0;

float height_of(vec3 point) {
    return frame.anchor_height_m
        + height_difference(point + frame.camera_offset_m, frame.anchor_up, planet.radius_m + frame.anchor_height_m);
}

// A height that no point between two depths of a tile is below: along a fixed direction heights grow no faster than
// upwards, and they are linear, so the least is at a corner.
float least_height(ivec2 first, vec2 depth) {
    vec2 low = ndc_of_pixel(vec2(first)), high = ndc_of_pixel(vec2(first + TILE_PX));
    vec3 middle = position_from_depth(0.5 * (low + high), sqrt(depth.x * depth.y)), up = up_at(middle);
    float least = 0.0;
    for (int k = 0; k < 8; ++k) {
        vec3 point = position_from_depth(vec2((k & 1) == 0 ? low.x : high.x, (k & 2) == 0 ? low.y : high.y),
            (k & 4) == 0 ? depth.x : depth.y);
        least = min(least, dot(point - middle, up));
    }
    return height_of(middle) + least;
}

// What terrain/shade.comp takes for the height of a pixel, or less: of the triangle, or where its chord sinks by more
// than 2 m partly, and from 20 m on wholly, what its vertices say. between: codes of spacings surely finer and surely
// coarser than these.
float counted_height(ivec2 pixel, vec2 between) {
    float drawn = height_of(position_from_depth(ndc_of_pixel(vec2(pixel) + 0.5),
        max(texel_at(u_depth, pixel).r, 1e-30)));
    vec4 attributes = texel_at(u_attributes, pixel);
    float coded = mix(planet.lowest_m, planet.highest_m, attributes.z), code = attributes.z > 0.0 ? attributes.w : 0.0;
    return code < between.x ? drawn : code > between.y ? coded : min(drawn, coded);
}

// Whether crowns may show between two depths of a tile. A point is at least as far away as its depth says.
bool crowned(ivec2 first, vec2 depth) {
    vec2 low = ndc_of_pixel(vec2(first)), high = ndc_of_pixel(vec2(first + TILE_PX)), widest = max(abs(low), abs(high));
    float farthest_m = length(position_from_depth(widest, depth.y));
    farthest_m = max(farthest_m, length(position_from_depth(vec2(-widest.x, widest.y), depth.y)));
    farthest_m = max(farthest_m, length(position_from_depth(vec2(widest.x, -widest.y), depth.y)));
    farthest_m = max(farthest_m, length(position_from_depth(-widest, depth.y)));
    return forward_distance(depth.x) < u_crowns_m.y && farthest_m > u_crowns_m.x;
}

void main() {
    uint lane = spread_group() * 64u + gl_LocalInvocationID.x;
    uint own = lane < uint(u_tiles.x * u_tiles.y) ? flags[lane] : 0u;
    bool there = (own & (1u << SURFACE_TERRAIN | SURFACE_ASKED)) != 0u, near = (own & SURFACE_NEAR) != 0u;
    ivec2 at = ivec2(int(lane) % u_tiles.x, int(lane) / u_tiles.x), first = at * TILE_PX;
    vec2 depth = there ? max(depths[lane], 1e-30) : vec2(1e-30);
    uint tile = uint(at.x) | uint(at.y) << 16;
    float reach = water_reach() + HAIR_M;
    bool coarse = forward_distance(depth.x) * frame.pixel_rad > COARSE_M;
    int turns = !there || (!coarse && least_height(first, depth) > reach) ? 0 : TILE_PX.x * TILE_PX.y;
    vec2 between = vec2(spacing_encode(4.0 * sqrt(planet.radius_m)), spacing_encode(12.65 * sqrt(planet.radius_m)))
        + vec2(-1.5, 1.5) / 255.0;
    ivec2 last = textureSize(u_surface, 0) - 1;
    bool wet = false;
    for (int k = 0; k < turns; ++k) {
        ivec2 pixel = min(first + ivec2(k & (TILE_WIDTH - 1), uint(k) / uint(TILE_WIDTH)), last);
        wet = wet || (counted_height(pixel, between) < reach && texel_at(u_surface, pixel).r == SURFACE_TERRAIN);
    }
#ifdef LAND_WATER
    wet = wet || (own & SURFACE_WATER_ASHORE) != 0u;
#endif
    if (!there) return;
    int list = (wet ? 1 : 0) + (near ? 2 : 0) + (crowned(first, depth) ? 4 : 0), groups = list * u_stride;
    sorted[groups + 4 + int(atomicAdd(sorted[groups], 1u))] = tile;
}
