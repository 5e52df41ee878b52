// Sorts tiles with ground by whether water changes any of it (contract "water", and rivers): the others are shaded
// without. A lane a tile. Most are settled by the depths between which all of it lies; in the rest each pixel is looked
// at.
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
layout(std430, binding = 0) readonly buffer FarBuffer { uint groups[4]; uint tiles[]; } far_list;
layout(std430, binding = 1) readonly buffer NearBuffer { uint groups[4]; uint tiles[]; } near_list;
layout(std430, binding = 7) readonly buffer DepthBuffer { vec2 depths[]; };
layout(binding = DEPTH_UNIT) uniform sampler2D u_depth;
layout(binding = ATTRIBUTES_UNIT) uniform sampler2D u_attributes;
layout(binding = SURFACE_UNIT) uniform usampler2D u_surface;
#ifdef LAND_WATER
layout(std430, binding = 4) readonly buffer FlagBuffer { uint flags[]; };
#endif
uniform ivec2 u_tiles;

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

void main() {
    uint lane = spread_group() * 64u + gl_LocalInvocationID.x, distant = far_list.groups[0];
    bool near = lane >= distant, there = lane < distant + near_list.groups[0];
    uint tile = there ? near ? near_list.tiles[lane - distant] : far_list.tiles[lane] : 0u;
    ivec2 at = ivec2(tile & 0xffffu, tile >> 16), first = at * TILE_PX;
    vec2 depth = max(depths[at.y * u_tiles.x + at.x], 1e-30);
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
    wet = wet || (there && (flags[at.y * u_tiles.x + at.x] & SURFACE_WATER_ASHORE) != 0u);
#endif
    if (there && !near && !wet) dry_list.tiles[atomicAdd(dry_list.groups[0], 1u)] = tile;
    if (there && !near && wet) wet_list.tiles[atomicAdd(wet_list.groups[0], 1u)] = tile;
    if (there && near && !wet) near_dry_list.tiles[atomicAdd(near_dry_list.groups[0], 1u)] = tile;
    if (there && near && wet) near_wet_list.tiles[atomicAdd(near_wet_list.groups[0], 1u)] = tile;
}
