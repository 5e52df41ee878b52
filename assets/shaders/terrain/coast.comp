// The line between land and water from heights at every fourth pixel (terrain.coast_px 4), interpolated between: for
// weak machines. terrain/coast_ask.comp asks at each pixel or every second.
//
// A workgroup a tile. Its lanes have a corner of the tile's blocks each, then half a block.
#include "generated/bindings.glsl"
#include "terrain/coast_pixel.glsl"
#include "common/spread.glsl"

layout(local_size_x = 16) in;
layout(std430, binding = TILE_BUFFER) readonly buffer TileBuffer {
    uint tile_groups[4];
    uint tiles[];
};
const ivec2 HALF = ivec2(4, 2);
const int COLUMNS = 5, CORNERS = 15;
shared vec4 s_ground[CORNERS];      // xyz: gradient; w: height above the sea
shared vec4 s_attributes[CORNERS];  // w: depth, 0 where there is nothing
// How far depth may be from linear on screen, relative, before pixels beside one another count as parts of different
// ground.
const float RIDGE = 0.005;
// How many times as near as drawn sea a corner may be before it is a shore in front of that water.
const float NEARER = 1.2;

void sample_ground(int index, ivec2 first) {
    ivec2 pixel = min(first + COAST_STEP * ivec2(index % COLUMNS, index / COLUMNS), textureSize(u_surface, 0) - 1);
    float depth = texel_at(u_depth, pixel).r;
    vec3 point = position_from_depth(ndc_of_pixel(vec2(pixel) + 0.5), max(depth, 1e-30));
    float drawn;
    vec3 D = foot_offset_of(point, drawn);
    float spacing = vertex_spacing(D, texel_at(u_attributes, pixel).w);
    // Heights have all layers down to an eighth of this: what is shorter than 1.5 steps would only make dots of the
    // samples.
    TerrainPoint terrain = terrain_point(D, 12.0 * float(COAST_STEP) * length(point) * frame.pixel_rad);
    float height = frame.anchor_height_m + terrain.dh;
    bool there = depth > 0.0;   // beside the limb there is nothing, and nothing finite comes of it
    s_ground[index] = there ? vec4(terrain.gradient, height - planet.sea_level_m) : vec4(0.0);
    s_attributes[index] = there ? vec4(terrain_attributes(terrain, height, spacing).xyz, depth) : vec4(0.0);
}

// Shares of a block's corners in a pixel of it, those that see nothing left out.
vec4 corner_shares(ivec2 in_block, vec4 depths) {
    vec2 part = vec2(in_block) / float(COAST_STEP), rest = 1.0 - part;
    vec4 shares = vec4(rest.x * rest.y, part.x * rest.y, rest.x * part.y, part.x * part.y)
        * vec4(greaterThan(depths, vec4(0.0)));
    return shares / max(dot(shares, vec4(1.0)), 1e-3);
}

void main() {
    uint tile = tiles[spread_tiles()];
    ivec2 first = ivec2(tile & 0xffffu, tile >> 16) * TILE_PX;
    int lane = int(gl_LocalInvocationIndex);
    sample_ground(min(lane, CORNERS - 1), first);
    barrier();

    ivec2 here = ivec2(lane & 3, lane >> 2), last = textureSize(u_surface, 0) - 1;
    int corner = (here.y >> 1) * COLUMNS + here.x, below = corner + COLUMNS;
    vec4 heights = vec4(s_ground[corner].w, s_ground[corner + 1].w, s_ground[below].w, s_ground[below + 1].w);
    vec4 depths = vec4(s_attributes[corner].w, s_attributes[corner + 1].w, s_attributes[below].w,
        s_attributes[below + 1].w);
    float nearest = max(max(depths.x, depths.y), max(depths.z, depths.w));
    uint land = 0u;
    for (int k = 0; k < HALF.x * HALF.y; ++k) {
        ivec2 in_half = ivec2(k & 3, k >> 2), pixel = first + HALF * here + in_half;
        CoastPixel p = coast_pixel(min(pixel, last));
        vec4 shares = corner_shares(ivec2(in_half.x, in_half.y + 2 * (here.y & 1)), depths);
        float above = dot(shares, heights);
        // Along a plane depth is linear on screen. Where it is not, the corners lie before and behind a ridge, and what
        // they see is not the ground of this pixel: what was drawn stays. So does water behind a shore.
        bool ridge = p.surface == SURFACE_TERRAIN ? abs(dot(shares, depths) - p.depth) > RIDGE * p.depth
            : nearest > NEARER * p.depth;
        bool asked = p.open && all(lessThanEqual(pixel, last)) && shares != vec4(0.0) && !ridge;
        if (asked && above < 0.0) coast_to_sea(pixel, p, -above);
        land |= asked && above >= 0.0 && p.surface == SURFACE_SEA ? 1u << k : 0u;
    }

    for (; land != 0u; land &= land - 1u) {
        int k = findLSB(land);
        ivec2 in_half = ivec2(k & 3, k >> 2), pixel = first + HALF * here + in_half;
        vec4 shares = corner_shares(ivec2(in_half.x, in_half.y + 2 * (here.y & 1)), depths);
        vec4 ground = shares.x * s_ground[corner] + shares.y * s_ground[corner + 1] + shares.z * s_ground[below]
            + shares.w * s_ground[below + 1];
        vec4 attributes = shares.x * s_attributes[corner] + shares.y * s_attributes[corner + 1]
            + shares.z * s_attributes[below]
            + shares.w * s_attributes[below + 1];
        coast_to_land(pixel, coast_pixel(pixel), ground.xyz, ground.w, attributes.xyz);
    }
}
