// Rivers and lakes in the picture, pixel by pixel: where a pixel's place on the ground lies in water, its line of sight
// meets that water first. terrain/land_water.frag makes these pixels a part of the sea's surface; the others keep how
// much water too narrow for a pixel covers them, and how wet they are (terrain/shade.comp). A workgroup a tile of
// terrain/list_water.comp.
//
//   WATER_FAR    pixels so wide that what they show is as good as where their line of sight meets the water
//   WATER_WIDE   tiles too wide for a list of lines: each pixel asks those of its cell
#include "common/dither.glsl"
#include "terrain/land_water.glsl"
#include "common/octahedral.glsl"
#include "common/sea_depth.glsl"
#include "common/spread.glsl"
#include "terrain/water_place.glsl"
#include "terrain/waters.glsl"
#include "terrain/tile_waters.glsl"

layout(local_size_x = TILE_WIDTH, local_size_y = TILE_HEIGHT) in;
layout(std430, binding = FLAG_BUFFER) buffer FlagBuffer { uint flags[]; };
layout(std430, binding = SEA_TILES_BUFFER) buffer SeaBuffer { uint sea_groups[4]; uint sea_tiles[]; };
layout(std430, binding = NARROW_WATER_BUFFER) buffer NarrowBuffer { uint narrow_groups[4]; uint narrow_tiles[]; };
layout(std430, binding = TILE_BUFFER) readonly buffer TileBuffer { uint tile_groups[4]; uint tiles[]; };
layout(binding = ATTRIBUTES_UNIT) uniform sampler2D u_attributes;
layout(binding = 0) writeonly uniform uimage2D u_land_water_out;
uniform ivec2 u_tiles;

const float FLATTEST_SINE = 0.03;   // of the view above the ground: what a pixel covers grows no longer below it

const uint SURFACE_WATER_NARROW = 1u;   // here alone: some of a pixel is water
const float SEA_HAIR_M = 0.01;      // more than rounding does to a level: inlets at the sea's are the sea

shared uint s_water;
#ifndef WATER_WIDE
// The tile's lines; as scalars and vectors, which software GPUs find sooner than structures.
shared int s_count;
shared ivec3 s_a[WATER_LINES];
shared vec3 s_way[WATER_LINES];
shared vec4 s_above[WATER_LINES], s_below[WATER_LINES];
shared vec3 s_above_more[WATER_LINES], s_below_more[WATER_LINES];

void take_lines(int record) {
    int lane = int(gl_LocalInvocationIndex), count = water_lines[record * WATER_RECORD];
    if (lane == 0) s_count = count;
    if (lane < count) {
        RiverEnds ends = river_ends_of(water_lines[record * WATER_RECORD + 1 + lane]);
        s_a[lane] = ends.a;
        s_way[lane] = ends.way;
        s_above[lane] = ends.above;
        s_below[lane] = ends.below;
        s_above_more[lane] = ends.above_more;
        s_below_more[lane] = ends.below_more;
    }
}
#endif

#ifdef WATER_WIDE
RiverEnds ends_at(int k) { return river_ends(k); }
#else
RiverEnds ends_at(int k) {
    return RiverEnds(s_a[k], s_way[k], s_above[k], s_below[k], s_above_more[k], s_below_more[k]);
}
#endif

// What the water around a place is; nothing where it is not asked. From afar the nearest line stands for all.
LandWater water_around(vec3 D, bool asked, vec3 across, vec3 along) {
    LandWater w = NO_LAND_WATER;
    WaterSums sums = NO_WATER_SUMS;
#ifdef WATER_WIDE
    float least = WATER_LEAST_PX * 0.5 * length(across);
    RiverPlace p = river_unbent(D);
    if (asked) p.lines = river_lines(river_cell(p), least);
    int begin = p.lines.x, k = begin, end = begin + p.lines.y;
    if (k < end && river_packed_half_width(river_packed_line(k)) <= least) end = begin;
    p = river_bent(p, D, k < end ? RIVER_BENDS : 0);
#define NEXT_LINE (++k < end && river_packed_half_width(river_packed_line(k)) > least)
#else
    int octaves = RIVER_BENDS;
#ifdef WATER_FAR
    // Short bends move a line by less than a quarter of a wide pixel.
    octaves = 4.0 * terrain_table.rivers.bends[1].value < length(across) ? 1 : octaves;
#endif
    RiverPlace p = river_bent(river_unbent(D), D, octaves);
    int begin = 0, k = 0, end = asked ? s_count : 0;
#define NEXT_LINE (++k < end)
#endif
#ifdef WATER_FAR
    float coverage = 0.0, nearest = WATER_NOWHERE_M;
    int best = begin;
    if (k < end) do {
        RiverLine line = river_line(ends_at(k), p);
        float beyond = line.d - line.bank;
        coverage = max(coverage, water_share_of(line, water_reach_of(line, p, across, along)));
        best = beyond < nearest ? k : best;
        nearest = min(nearest, beyond);
    } while (NEXT_LINE);
    if (end > begin) land_water_add(w, sums, river_line(ends_at(best), p), p, across, along);
    w.coverage = coverage;
#else
    if (k < end) do {
        land_water_add(w, sums, river_line(ends_at(k), p), p, across, along);
    } while (NEXT_LINE);
#endif
    land_water_end(w, sums, p);
    return w;
}

// What a pixel's sides cover of level ground.
void pixel_sides(WaterPlace place, vec3 up, out vec3 across, out vec3 along) {
    float distance_m = length(place.point), width = distance_m * frame.pixel_rad;
    vec3 view = -place.point / distance_m, aside = cross(view, up);
    aside /= max(length(aside), 1e-6);
    across = aside * width;
    along = cross(up, aside) * (width / max(dot(view, up), FLATTEST_SINE));
}

// How high a share of the way to a point lies over water whose level is known at another share of it and changes
// evenly,
// by `rise` on the whole way.
float over_water(vec3 point, float share, float level, float known_at, float rise) {
    float height;
    foot_offset_of(share * point, height);
    return height - frame.anchor_height_m - level - (share - known_at) * rise;
}

// The share at which it meets that water, between the camera above and the point below it: nearly linear.
float share_to_water(vec3 point, float level, float known_at, float rise) {
    float over = over_water(point, 0.0, level, known_at, rise), under = over_water(point, 1.0, level, known_at, rise);
    float steep = max(over - under, 1e-6), share = clamp(over / steep, 0.0, 1.0);
    share += over_water(point, share, level, known_at, rise) / steep;
    share += over_water(point, share, level, known_at, rise) / steep;
    return clamp(share, 0.0, 1.0);
}

// Height of the ground over the anchor's: as samples have it, where they do, since distant vertices don't know its
// shores; drawn_m: of the pixel's place.
float ground_at(vec3 D, float width_m, float drawn_m) {
#ifdef TERRAIN_TILED
    RealGround real = terrain_real(D, width_m);
    vec3 up = terrain_table.up + D / terrain_table.radius_m, unused;
    float below_m = terrain_real_relief(real, D, up, width_m, unused);
    return TERRAIN_SINGLE(real.height) + real.rest * drawn_m + (real.rest < 1.0 ? below_m : 0.0);
#else
    return drawn_m;
#endif
}

// x: depth of the water's surface, 0 for ground; y: its normal, or what the ground's light asks; z: its attributes, or
// on ground how deep the nearest water is in its middle, m; w: on ground, how much of it is gravel, 0..1.
uvec4 pixel_of(ivec2 pixel) {
    WaterPlace place = water_place(pixel);
    vec3 up = up_at(place.point), across, along;
    pixel_sides(place, up, across, along);
    LandWater w = water_around(place.D, place.open, across, along);
    bool water = w.beyond < 0.0 && w.wide
        && (place.surface == SURFACE_TERRAIN || w.level > planet.sea_level_m - frame.anchor_height_m + SEA_HAIR_M);
    float share = 1.0;
    float rise = dot(w.slope, place.point);
    float ground_over = over_water(place.point, 1.0, w.level, 1.0, rise);
    bool sunk = water && ground_over < 0.0 && over_water(place.point, 0.0, w.level, 1.0, rise) > 0.0;
    // The shore of a lake on a map is the ground's, wherever its lines reach.
    bool mapped = terrain_table.rivers.given != 0 && w.lake > 0.5;
    if (mapped && w.beyond < 0.0) ground_over = ground_at(place.D, length(across), ground_over + w.level) - w.level;
    water = water && (ground_over < 0.0 || !mapped);
    w.above = mapped ? (w.beyond < 0.0 ? max(ground_over, 0.0) : WATER_NOWHERE_M) : w.above;
    w.coverage = mapped && ground_over > 0.0 ? 0.0 : w.coverage;
    if (sunk) share = share_to_water(place.point, w.level, 1.0, rise);
    bool better = false;
    LandWater there = w;
#ifndef WATER_FAR
    // Depth and level where the surface is seen.
    float drawn;
    vec3 D = foot_offset_of(share * place.point, drawn);
    there = water_around(D, sunk, across, along);
    better = sunk && there.beyond < 0.0;
    if (better) share = share_to_water(place.point, there.level, share, dot(there.slope, place.point));
#endif
    float depth_m = better ? there.depth : w.depth;
    depth_m = mapped ? max(-ground_over, 0.0) : depth_m;
    vec3 tilt = better ? there.tilt : w.tilt;
    tilt -= up * dot(up, tilt);
    vec3 normal = normalize(up_at(share * place.point) - tilt);

    vec4 attributes = vec4(sea_depth_encode(depth_m / (depth_m + 16.0)), land_water_encode(w.stirred, w.muddy,
        dither_noise(pixel).x + 0.5),
        texel_at(u_attributes, min(pixel, textureSize(u_surface, 0) - 1)).w);
    float width = max(length(across), 1e-3);
    float damp = smoothstep(WATER_DAMP_M, 0.3 * WATER_DAMP_M, w.above)
        * clamp(4.0 * (w.half_width + 1.0) / width, 0.0, 1.0) * float(w.beyond < WATER_NOWHERE_M);
    float soft = max(0.5 * width, 0.3);
    float barred = (1.0 - smoothstep(-soft, soft, w.bar)) * float(!mapped)
        * clamp(0.5 * (w.half_width + 1.0) / width, 0.0, 1.0);
    bool ground = place.open && place.surface == SURFACE_TERRAIN;
    vec4 ashore = ground ? vec4(w.coverage, damp, w.stirred, w.muddy) : vec4(0.0);
    return water ? uvec4(floatBitsToUint(place.depth / max(share, 1e-6)), packSnorm2x16(oct_encode(normal)),
        packUnorm4x8(attributes), 0u) : uvec4(0u, packUnorm4x8(ashore), floatBitsToUint(w.deep),
        ground ? packUnorm2x16(vec2(barred, 0.0)) : 0u);
}

void main() {
    uint tile = tiles[spread_tiles()];
    ivec2 at = ivec2(tile & 0xffffu, tile >> 16), pixel = at * TILE_PX + ivec2(gl_LocalInvocationID.xy);
    if (gl_LocalInvocationIndex == 0u) s_water = 0u;
#ifndef WATER_WIDE
    take_lines(at.y * u_tiles.x + at.x);
#endif
    memoryBarrierShared();
    barrier();
    uvec4 found = pixel_of(pixel);
    bool inside = all(lessThan(pixel, textureSize(u_surface, 0)));
    if (inside) imageStore(u_land_water_out, pixel, found);
    if (inside && found.x != 0u) atomicOr(s_water, SURFACE_LAND_WATER);
    bool ashore = (found.y & 0xffffu) != 0u || found.w != 0u;
    if (inside && found.x == 0u && ashore) atomicOr(s_water, SURFACE_WATER_ASHORE);
    if (inside && found.x == 0u && (found.y & 0xffu) != 0u) atomicOr(s_water, SURFACE_WATER_NARROW);
    memoryBarrierShared();
    barrier();
    if (gl_LocalInvocationIndex != 0u) return;
    int index = at.y * u_tiles.x + at.x;
    if ((s_water & SURFACE_WATER_ASHORE) != 0u) atomicOr(flags[index], SURFACE_WATER_ASHORE);
    if ((s_water & SURFACE_WATER_NARROW) != 0u) narrow_tiles[atomicAdd(narrow_groups[0], 1u)] = tile;
    if ((s_water & SURFACE_LAND_WATER) != 0u) {
        uint before = atomicOr(flags[index], 1u << SURFACE_SEA | SURFACE_LAND_WATER);
        if ((before & (1u << SURFACE_SEA | SURFACE_ASKED)) == 0u)
            sea_tiles[atomicAdd(sea_groups[0], 1u)] = tile;
    }
}
