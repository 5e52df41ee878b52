// Tiles of the picture that a river or a lake may show in, and the lines of water that count in them. A lane a tile.
#include "terrain/water_place.glsl"
#include "terrain/waters.glsl"
#include "terrain/tile_waters.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = FLAG_BUFFER) buffer FlagBuffer { uint flags[]; };
layout(std430, binding = TILE_BUFFER) buffer TileBuffer { uint groups[4]; uint tiles[]; } few_list;
layout(std430, binding = WIDE_WATER_BUFFER) buffer WideBuffer { uint groups[4]; uint tiles[]; } wide_list;
uniform ivec2 u_tiles;

const int LOOKS = 9;
// Places between those are no further from their middle than so many times as far as these; and the warp that bends
// lines stretches lengths.
const float WITHIN = 1.2, STRETCHED = 1.6;
const float BANKS_OUT_M = 101.0;   // 0.3 of the three wavelengths that move them (systems/terrain/rivers/form.py)
const int TRIES = 4;
const int MOST_BLOCKS = 128;   // more are not looked at

// What of the ground a tile shows.
struct TileGround {
    vec3 middle, half_box;
    float radius;      // m around the middle
    float narrowest;   // m: half of its narrowest pixel
    bool some;
};

WaterPlace look(ivec2 first, int k) {
    return water_place(first + ivec2(k % 3, k / 3) * (TILE_PX - 1) / 2);
}

TileGround tile_ground(ivec2 first, int looks) {
    vec3 low = vec3(3.0e38), high = vec3(-3.0e38);
    float nearest = 3.0e38, radius = 0.0;
    for (int k = 0; k < looks; ++k) {
        WaterPlace place = look(first, k);
        low = place.open ? min(low, place.D) : low;
        high = place.open ? max(high, place.D) : high;
        nearest = place.open ? min(nearest, length(place.point)) : nearest;
    }
    bool some = low.x <= high.x;
    vec3 middle = some ? 0.5 * (low + high) : vec3(0.0), half_box = some ? WITHIN * 0.5 * (high - low) : vec3(0.0);
    for (int k = 0; k < looks; ++k) {
        WaterPlace place = look(first, k);
        radius = place.open ? max(radius, WITHIN * length(place.D - middle)) : radius;
    }
    return TileGround(middle, half_box, radius, 0.5 * nearest * frame.pixel_rad, some);
}

// Lines in the cells that a tile's ground lies in.
struct TileLines {
    int count;   // with those beyond WATER_LINES, which are not kept
    bool near;   // any may show in it
};

// How far from the water banks may be wet: where they, or the valley's floor, have risen by WATER_DAMP_M.
float damp_width(float half_width, float depth) {
    return WATER_DAMP_M * min((half_width + 2.0) / max(RIVER_BANK_SHARE * depth, 0.01), 1.0 / RIVER_FLOOR_SLOPE);
}

// least: half widths that are looked at, m.
TileLines tile_lines(TileGround ground, ivec3 low, ivec3 sides, int cells, float least, int first) {
    RiverPlace p = river_bent(river_unbent(ground.middle), ground.middle, RIVER_BENDS);
    float radius = STRETCHED * ground.radius + 4.0 * ground.narrowest;
    TileLines found = TileLines(0, false);
    int cell = 0;
    if (cells > 0) do {
        ivec2 lines = river_lines(low + ivec3(cell % sides.x, cell / sides.x % sides.y, cell / (sides.x * sides.y)),
            least);
        int k = lines.x, end = lines.x + lines.y, packed_line = k < end ? river_packed_line(k) : 0;
        float half_width = river_packed_half_width(packed_line);
        if (half_width > least) do {
            RiverLine line = river_line(river_ends_of(packed_line), p);
            // Banks are nowhere further out than the floor and than noise moves them.
            float uneven = clamp(line.section.w - line.section.y, 0.0, min(RIVER_BANK_OUT * half_width, BANKS_OUT_M));
            float beyond = line.d - half_width - uneven, damp = damp_width(half_width, line.section.z);
            damp = max(damp, terrain_table.rivers.uneven * min(0.6 * half_width + 0.3, BAR_STRIP_M + BAR_MOST_M));
            damp = damp > ground.narrowest ? damp : 0.0;
            bool known = beyond > radius + WATER_AROUND_M;
            int j = 0, kept = min(found.count, WATER_LINES);
            if (j < kept) do {
                known = known || (water_lines[first + 1 + j] & RIVER_NODE_MASK) == (packed_line & RIVER_NODE_MASK);
            } while (++j < kept);
            found.near = found.near || beyond < radius + damp;
            if (!known && found.count < WATER_LINES) water_lines[first + 1 + found.count] = packed_line;
            found.count += known ? 0 : 1;
            packed_line = ++k < end ? river_packed_line(k) : 0;
            half_width = river_packed_half_width(packed_line);
        } while (half_width > least);
    } while (++cell < cells);
    return found;
}

void main() {
    int tile = int(gl_GlobalInvocationID.x);
    bool there = tile < u_tiles.x * u_tiles.y;
    uint shown = there ? flags[tile] : 0u;
    ivec2 at = ivec2(tile % u_tiles.x, tile / u_tiles.x);
    bool asked = (shown & (1u << SURFACE_TERRAIN | 1u << SURFACE_SEA)) != 0u;
    TileGround ground = tile_ground(at * TILE_PX, asked ? LOOKS : 0);
    ivec3 low = river_cell(river_unbent(ground.middle - ground.half_box));
    ivec3 sides = river_cell(river_unbent(ground.middle + ground.half_box)) - low + 1;
    bool wide = ground.some && any(greaterThan(sides, ivec3(3)));
    // Pixels ask cells of their own, which may lie beyond the looks.
    ivec3 beyond = sides / 4 + 1;
    float least_wide = WATER_LEAST_PX * ground.narrowest;
    bool none = wide && river_widest(low - beyond, low + sides + beyond, wide ? MOST_BLOCKS : 0) <= least_wide;
    int cells = ground.some && !wide ? sides.x * sides.y * sides.z : 0, turn = 0;
    // Where there are too many, the narrowest go.
    float least = least_wide;
    TileLines found = TileLines(0, false);
    do {
        TileLines now = tile_lines(ground, low, sides, cells, least, tile * WATER_RECORD);
        found = now;
        least *= 2.0;
    } while (found.count > WATER_LINES && ++turn < TRIES);
    if (found.near || wide && !none) {
        flags[tile] = shown | SURFACE_WATER_ASKED;
        uint place = uint(at.x) | uint(at.y) << 16;
        water_lines[tile * WATER_RECORD] = min(found.count, WATER_LINES);
        if (wide) wide_list.tiles[atomicAdd(wide_list.groups[0], 1u)] = place;
        else few_list.tiles[atomicAdd(few_list.groups[0], 1u)] = place;
    }
}
