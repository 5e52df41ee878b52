// Tiles of the picture that a river or a lake may show in, and the lines of water that count in them. A lane a tile.
#include "terrain/water_place.glsl"
#include "terrain/waters.glsl"
#include "terrain/tile_waters.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = FLAG_BUFFER) buffer FlagBuffer { uint flags[]; };
layout(std430, binding = TILE_BUFFER) buffer TileBuffer { uint groups[4]; uint tiles[]; } few_list;
layout(std430, binding = 1) buffer WideBuffer { uint groups[4]; uint tiles[]; } wide_list;   // that have too many
uniform ivec2 u_tiles;

const int LOOKS = 9;
// Places between those are no further from their middle than so many times as far as these; and the warp that bends
// lines stretches lengths.
const float WITHIN = 1.3, STRETCHED = 1.6;
// Lines that are further from a tile change its levels by less than a millimetre.
const float AROUND_M = 200.0;
const int MOST_CELLS = 27;

// What of the ground a tile shows.
struct TileGround {
    vec3 middle, half_box;
    float narrowest;   // m: half of its narrowest pixel
    bool any;
};

TileGround tile_ground(ivec2 first, int looks) {
    vec3 low = vec3(3.0e38), high = vec3(-3.0e38);
    float nearest = 3.0e38;
    for (int k = 0; k < looks; ++k) {
        WaterPlace place = water_place(first + ivec2(k % 3, k / 3) * (TILE_PX - 1) / 2);
        low = place.open ? min(low, place.D) : low;
        high = place.open ? max(high, place.D) : high;
        nearest = place.open ? min(nearest, length(place.point)) : nearest;
    }
    bool any = low.x <= high.x;
    return TileGround(any ? 0.5 * (low + high) : vec3(0.0), any ? WITHIN * 0.5 * (high - low) : vec3(0.0),
        0.5 * nearest * frame.pixel_rad, any);
}

void main() {
    int tile = int(gl_GlobalInvocationID.x);
    bool there = tile < u_tiles.x * u_tiles.y;
    uint shown = there ? flags[tile] : 0u;
    ivec2 at = ivec2(tile % u_tiles.x, tile / u_tiles.x);
    TileGround ground = tile_ground(at * TILE_PX, (shown & (1u << SURFACE_TERRAIN | 1u << SURFACE_SEA)) != 0u ? LOOKS : 0);
    RiverPlace p = river_bent(river_unbent(ground.middle), ground.middle, RIVER_BENDS);
    ivec3 low = river_cell(river_unbent(ground.middle - ground.half_box));
    ivec3 sides = river_cell(river_unbent(ground.middle + ground.half_box)) - low + 1;
    int cells = ground.any ? sides.x * sides.y * sides.z : 0;
    bool wide = any(greaterThan(sides, ivec3(3))) && ground.any, near = wide;
    float radius = STRETCHED * length(ground.half_box) + 4.0 * ground.narrowest;
    int count = 0, first = tile * WATER_RECORD, cell = 0;
    if (!wide && cells > 0) do {
        ivec2 lines = river_lines(low + ivec3(cell % sides.x, cell / sides.x % sides.y, cell / (sides.x * sides.y)));
        int k = lines.x, end = lines.x + lines.y;
        int packed_line = k < end ? river_packed_line(k) : 0;
        float half_width = river_packed_half_width(packed_line);
        if (half_width > WATER_LEAST_PX * ground.narrowest) do {
            float beyond = river_line(river_ends(k), p).d - half_width;
            bool known = beyond > radius + AROUND_M;
            int j = 0;
            if (j < count) do {
                known = known || (water_lines[first + 1 + j] & RIVER_NODE_MASK) == (packed_line & RIVER_NODE_MASK);
            } while (++j < min(count, WATER_LINES));
            near = near || beyond < radius;
            if (!known && count < WATER_LINES) water_lines[first + 1 + count] = packed_line;
            count += known ? 0 : 1;
            packed_line = ++k < end ? river_packed_line(k) : 0;
            half_width = river_packed_half_width(packed_line);
        } while (half_width > WATER_LEAST_PX * ground.narrowest);
    } while (++cell < cells);
    if (near) {
        flags[tile] = shown | SURFACE_WATER_ASKED;
        uint place = uint(at.x) | uint(at.y) << 16;
        wide = wide || count > WATER_LINES;
        water_lines[first] = count;
        if (wide) wide_list.tiles[atomicAdd(wide_list.groups[0], 1u)] = place;
        else few_list.tiles[atomicAdd(few_list.groups[0], 1u)] = place;
    }
}
