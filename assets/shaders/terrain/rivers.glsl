// What rivers make of the ground: the GPU's side of systems/terrain/rivers/. Part of terrain/height.glsl, which has the
// table and terrain_place. RIVER_PLAIN_AWAY: nobody asks how the distance from water changes but for its direction.
// The texture holds, one after the other (rivers/texture.py): columns of cells along z, two to a texel; cells of
// columns, four to a texel; lines of cells, four to a texel, the widest of a cell's first, with how wide they are; and
// nodes of three texels: place and the node downstream; level, half width, depth, half width of the floor; reach, 1 for
// a lake, discharge, how far it wanders.
#include "generated/bindings.glsl"
#include "common/pair.glsl"
#include "generated/terrain_river_form.glsl"

layout(binding = RIVERS_UNIT) uniform usampler2D u_terrain_rivers;

ivec4 river_texel(int index) {
    ivec2 place = ivec2(index & (RIVER_TEXTURE_WIDTH - 1), index >> RIVER_TEXTURE_BITS);
    return ivec4(texelFetch(u_terrain_rivers, place, 0));
}

float river_half_width_of(int code) {
    return code > 0 ? exp2(float(code) * (1.0 / RIVER_WIDTH_STEPS) + RIVER_WIDTH_LEAST) : 0.0;
}

// Lines that pass a cell: from x on, y of them; none where no half width in its column is above `least`, m, which takes
// one look-up. The sphere passes a column on either side of the equator.
ivec2 river_lines(ivec3 cell, float least) {
    int across = terrain_table.rivers.across, half_across = across >> 1;
    ivec2 c = clamp(cell.xy + half_across, 0, across - 1);
    int number = (cell.z < 0 ? 0 : across * across) + c.y * across + c.x;
    ivec4 two = river_texel(number >> 1);
    ivec2 column = (number & 1) != 0 ? two.zw : two.xy;
    int low = column.y & 1023, high = column.y >> 10 & 2047, z = cell.z + RIVER_HALF, packed_lines = 0;
    if (z >= low && z < high && river_half_width_of(column.y >> RIVER_WIDEST_BIT) > least) {
        int index = column.x + z - low;
        packed_lines = river_texel(terrain_table.rivers.first_cell + (index >> 2))[index & 3];
    }
    int bits = terrain_table.rivers.count_bits;
    return ivec2(packed_lines >> bits, packed_lines & ((1 << bits) - 1));
}

ivec2 river_lines(ivec3 cell) { return river_lines(cell, -1.0); }

// The largest half width, m, of lines in blocks of columns from `low` to `high`, which holds all cells between them;
// more than any where that are more than `most` blocks.
float river_widest(ivec3 low, ivec3 high, int most) {
    int across = terrain_table.rivers.across, side = (across + RIVER_BLOCK - 1) / RIVER_BLOCK;
    ivec2 first = clamp(low.xy + (across >> 1), 0, across - 1) / RIVER_BLOCK;
    ivec2 sides = clamp(high.xy + (across >> 1), 0, across - 1) / RIVER_BLOCK - first + 1;
    int half_first = low.z < 0 ? 0 : 1, halves = (high.z < 0 ? 0 : 1) - half_first + 1;
    int count = sides.x * sides.y * halves, widest = 0, k = 0;
    if (count > most) return 3.0e38;
    do {
        ivec2 at = first + ivec2(k % sides.x, k / sides.x % sides.y);
        int number = ((half_first + k / (sides.x * sides.y)) * side + at.y) * side + at.x;
        widest = max(widest, river_texel(terrain_table.rivers.first_block + (number >> 2))[number & 3]);
    } while (++k < count);
    return river_half_width_of(widest);
}

// A place as lines see it.
struct RiverPlace {
    ivec3 steps;   // of nodes' places
    vec3 rest;     // beyond them, steps: with the warp that bends lines
    vec3 up;
    mat3 turned;   // how it is moved by the place
    ivec2 lines;
    vec3 noise[RIVER_WATER_OCTAVES];    // moves water on its floor
    mat3 slopes[RIVER_WATER_OCTAVES];   // and how that changes with the place, 1/m
};

// Where D is, in steps and less than one.
#ifdef TERRAIN_CANONICAL
const int RIVER_FIXED_BITS = 8;   // steps in a unit of places in fixed point

ivec3 river_steps(Fixed3 D, out vec3 rest) {
    rest = vec3(D.part << RIVER_FIXED_BITS >> 8) * (1.0 / 16777216.0);
    return D.whole << RIVER_FIXED_BITS | ivec3(D.part >> (32 - RIVER_FIXED_BITS));
}
#else
ivec3 river_steps(vec3 D, out vec3 rest) {
    vec3 steps = D / terrain_table.rivers.step_m, whole = floor(steps);
    rest = (steps - whole) + terrain_table.rivers.rest;
    return terrain_table.rivers.anchor + ivec3(whole);
}
#endif

// Without lines, and not moved by the warp.
RiverPlace river_unbent(TERRAIN_PLACE D) {
    RiverPlace p;
    p.steps = river_steps(D, p.rest);
    p.lines = ivec2(0);
    p.up = terrain_table.up + terrain_offset(D) / terrain_table.radius_m;
    p.turned = mat3(1.0);
    for (int k = 0; k < RIVER_WATER_OCTAVES; ++k) {
        p.noise[k] = vec3(0.0);
        p.slopes[k] = mat3(0.0);
    }
    return p;
}

ivec3 river_cell(RiverPlace unbent) {
    return (unbent.steps + ivec3(floor(unbent.rest))) >> RIVER_CELL_BITS;
}

// One octave of the noise that moves water (systems/terrain/rivers/banks.py). steps, part: of the bent place.
#define RIVER_ASK_OCTAVE(k) { \
    int bits = terrain_table.rivers.longest_bits - 2 * k; \
    float per_step = exp2(float(-bits)); \
    vec3 fraction = (vec3(steps & ((1 << bits) - 1)) + part) * per_step; \
    p.noise[k] = vector_noise((steps >> bits) + RIVER_WATER_OFFSET * (k + 1), fraction, p.slopes[k]); \
    p.slopes[k] *= per_step / terrain_table.rivers.step_m; \
}

// Each octave is written out: once for a place, whatever its lines, and no array is indexed by a variable.
void river_ask_noise(inout RiverPlace p) {
    vec3 whole = floor(p.rest), part = p.rest - whole;
    ivec3 steps = p.steps + ivec3(whole);
    RIVER_ASK_OCTAVE(0) RIVER_ASK_OCTAVE(1) RIVER_ASK_OCTAVE(2) RIVER_ASK_OCTAVE(3) RIVER_ASK_OCTAVE(4)
}

// The same, moved by the warp, unless `octaves` is 0.
RiverPlace river_bent(RiverPlace p, TERRAIN_PLACE D, int octaves) {
    vec3 bend = vec3(0.0);
    int k = 0;
    if (octaves > 0) do {
        ivec3 cell;
        vec3 fraction;
        mat3 jacobian;
        TerrainLattice lattice = terrain_table.rivers.bends[k];
        terrain_place(lattice, D, cell, fraction);
        bend += lattice.value * vector_noise(cell, fraction, jacobian);
        p.turned += (lattice.value * lattice.frequency_per_m) * jacobian;
    } while (++k < octaves);
    p.rest += bend / terrain_table.rivers.step_m;
    river_ask_noise(p);
    return p;
}

RiverPlace river_place(TERRAIN_PLACE D) {
    RiverPlace p = river_unbent(D);
    p.lines = river_lines(river_cell(p));
    return river_bent(p, D, p.lines.y > 0 ? RIVER_BENDS : 0);
}

// A line of a river at a place: values of its nodes there, and how they change along the whole of it.
struct RiverLine {
    vec4 section, section_step;   // level over the anchor's base, half width, depth, half width of the floor
    float wander;                 // how far the water may lie from the line, along each axis, m
    float bank;                   // half width between uneven banks
    vec3 by_bank;                 // how that changes with the place
    float reach, reach_step, lake, discharge;
    float valley_d;               // m from the line
    vec3 valley_away;             // unit, from the line to the place
    float d;                      // the same from the water's, which wanders over the floor
    vec3 away;                    // how that changes with the place
    vec3 along;                   // change of the line's parameter, 1/m; 0 beyond its ends
    vec3 way;                     // of the whole line, m
};

vec3 river_level(vec3 v, vec3 up) { return v - up * dot(up, v); }

// What is known of a line's two nodes.
struct RiverEnds {
    ivec3 a;              // steps
    vec3 way;             // from there to b, steps
    vec4 above, below;    // at a, and downstream at b: level over the anchor's base, half width, depth, of the floor
    vec4 above_more, below_more;   // reach, 1 for a lake, discharge, how far it wanders, m
};

const int RIVER_NODE_MASK = (1 << RIVER_NODE_BITS) - 1;

// A line of a cell: which node it begins with, and its half width, rounded up (rivers/texture.py).
int river_packed_line(int index) {
    return river_texel(terrain_table.rivers.first_line + (index >> 2))[index & 3];
}

float river_packed_half_width(int packed_line) { return river_half_width_of(packed_line >> RIVER_NODE_BITS); }

RiverEnds river_ends_of(int packed_line) {
    int nodes = terrain_table.rivers.first_node, node = packed_line & RIVER_NODE_MASK;
    ivec4 a = river_texel(nodes + 3 * node), b = river_texel(nodes + 3 * a.w);
    RiverEnds ends;
    ends.a = a.xyz;
    ends.way = vec3(b.xyz - a.xyz);
    ends.above = intBitsToFloat(river_texel(nodes + 3 * node + 1));
    ends.below = intBitsToFloat(river_texel(nodes + 3 * a.w + 1));
    ends.above.x -= terrain_table.rivers.base_m;
    ends.below.x -= terrain_table.rivers.base_m;
    ends.above_more = intBitsToFloat(river_texel(nodes + 3 * node + 2));
    ends.below_more = intBitsToFloat(river_texel(nodes + 3 * a.w + 2));
    return ends;
}

RiverEnds river_ends(int index) {
    return river_ends_of(river_packed_line(index));
}

// Moves the place that a line's water is held against (systems/terrain/rivers/meanders.py). way, to_a: level, and to
// its beginning, steps.
void river_wander(inout RiverLine line, float wander_step, vec3 to_a, vec3 way, float per_square, RiverPlace p) {
    float wander = max(line.wander, 1e-3), longest = exp2(float(terrain_table.rivers.longest_bits))
        * terrain_table.rivers.step_m;
    float x = 0.5 * log2(longest * RIVER_MEANDER_SHARE / wander);
    float inside = x > 0.0 && x < float(RIVER_MEANDER_OCTAVES - 1) ? -0.7213475 / wander : 0.0;
    vec4 off = clamp(x, 0.0, float(RIVER_MEANDER_OCTAVES - 1)) - vec4(0.0, 1.0, 2.0, 3.0);
    vec4 weights = max(1.0 - abs(off), 0.0);
    vec4 by_wander = inside * -sign(off) * vec4(greaterThan(weights, vec4(0.0)));
    TerrainRiverWanderSlopes moved = terrain_river_wander_slopes(line.valley_d, line.section.y, line.wander);
    vec3 mixed = mat4x3(p.noise[0], p.noise[1], p.noise[2], p.noise[3]) * weights;
    vec3 more = mat4x3(p.noise[0], p.noise[1], p.noise[2], p.noise[3]) * by_wander;
    vec3 rest = p.rest + (moved.value / terrain_table.rivers.step_m) * mixed;
    float t = clamp(-dot(river_level(to_a - rest, p.up), way) * per_square, 0.0, 1.0);
    vec3 off_m = river_level(to_a + t * way - rest, p.up) * terrain_table.rivers.step_m;
    line.d = length(off_m);
    vec3 away = -off_m / max(line.d, 1e-9);
#ifdef RIVER_PLAIN_AWAY
    line.away = away;
#else
    vec3 by_place = moved.by_d * line.valley_away
        + (moved.by_half_width * line.section_step.y + moved.by_metres * wander_step) * line.along;
    line.away = away + moved.value * ((away * p.slopes[0]) * weights.x + (away * p.slopes[1]) * weights.y
        + (away * p.slopes[2]) * weights.z + (away * p.slopes[3]) * weights.w)
        + dot(away, mixed) * by_place + (moved.value * dot(away, more) * wander_step) * line.along;
#endif
}

// Without what noise moves. to_a, way: to its beginning, and of all of it, level, steps.
RiverLine river_still_line(RiverEnds ends, RiverPlace p, out vec3 to_a, out vec3 way, out float per_square) {
    // Steps: whole numbers of at most 24 bits.
    vec3 whole_way = ends.way;
    to_a = vec3(ends.a - p.steps);
    way = river_level(whole_way, p.up);
    per_square = 1.0 / max(dot(way, way), 1.0);
    float t = -dot(river_level(to_a - p.rest, p.up), way) * per_square;
    RiverLine line;
    line.along = t > 0.0 && t < 1.0 ? way * (per_square / terrain_table.rivers.step_m) : vec3(0.0);
    line.way = way * terrain_table.rivers.step_m;
    t = clamp(t, 0.0, 1.0);
#ifdef TERRAIN_FLOAT
    vec3 off = to_a + t * whole_way - p.rest;
#else
    // The line's point is as far away as its nodes, and the place may be next to it.
    Pair3 point = pair_add(pair_mul(whole_way, vec3(t)), to_a);
    vec3 off = point.high + (point.low - p.rest);
#endif
    off = river_level(off, p.up) * terrain_table.rivers.step_m;
    line.valley_d = length(off);
    line.valley_away = -off / max(line.valley_d, 1e-9);
    line.d = line.valley_d;
    line.away = line.valley_away;
    line.section_step = ends.below - ends.above;
    line.section = ends.above + t * line.section_step;
    line.reach_step = ends.below_more.x - ends.above_more.x;
    line.reach = ends.above_more.x + t * line.reach_step;
    line.lake = ends.above_more.y * ends.below_more.y;
    line.discharge = mix(ends.above_more.z, ends.below_more.z, t);
    line.wander = mix(ends.above_more.w, ends.below_more.w, t);
    line.by_bank = line.section_step.y * line.along;
    line.bank = line.section.y;
    return line;
}

// Whether noise may move its water at the place.
bool river_moved(RiverLine line) {
    return terrain_table.rivers.moves != 0
        && line.valley_d < RIVER_WATER_FAR * line.section.y + RIVER_MEANDER_FAR * line.wander;
}

RiverLine river_line(RiverEnds ends, RiverPlace p) {
    vec3 to_a, way;
    float per_square;
    RiverLine line = river_still_line(ends, p, to_a, way, per_square);
    if (river_moved(line)) {
        river_wander(line, ends.below_more.w - ends.above_more.w, to_a, way, per_square, p);
        TerrainRiverBankSlopes bank = terrain_river_bank_slopes(line.d, line.section.y, line.section.w,
            terrain_table.rivers.uneven, p.noise[2].x, p.noise[3].x, p.noise[4].x);
        line.bank = bank.value;
        line.by_bank = bank.by_d * line.away + bank.by_coarse * vec3(1.0, 0.0, 0.0) * p.slopes[2]
            + bank.by_middle * vec3(1.0, 0.0, 0.0) * p.slopes[3] + bank.by_fine * vec3(1.0, 0.0, 0.0) * p.slopes[4]
            + (bank.by_half_width * line.section_step.y + bank.by_floor_width * line.section_step.w) * line.along;
    }
    return line;
}

// What the ground is cut to. base: over the anchor's; open: share of the height above it that is left; raised: share of
// the depth below it that is filled. d_: gradients by the place, not yet tangential.
struct TerrainCut {
    float base, open, raised;
    float reach;   // of the valley, m; 0 where there is none
    float beside;  // 1 in the water .. 0 far from it
    vec3 d_base, d_open, d_raised;
};

const float BESIDE_M = 100.0;   // as systems/terrain/rivers/table.py has it

// How wet a line makes a place: 1 in its water .. 0 where its bank ends. Of a map's lakes nothing: their lines reach
// over dry ground.
float river_wets(RiverLine line) {
    float half_width = line.bank;
    bool given = terrain_table.rivers.given != 0;
    float wide = given ? BESIDE_M : min(BESIDE_M, max(line.reach - half_width, 1e-3));
    float near = 1.0 - (line.d - half_width) / wide;
    return half_width > 0.0 && !(given && line.lake > 0.5) ? clamp(near, 0.0, 1.0) : 0.0;
}

#ifndef TERRAIN_CARVED
// The most that any line of a map makes of it; no warp bends these.
float terrain_beside(TERRAIN_PLACE D) {
    float beside = 0.0;
    RiverPlace p = river_unbent(D);
    p.lines = river_lines(river_cell(p));
    int k = p.lines.x, end = p.lines.x + p.lines.y;
    if (k < end) do {
        beside = max(beside, river_wets(river_line(river_ends(k), p)));
    } while (++k < end);
    return beside;
}
#endif

TerrainCut terrain_cut(TERRAIN_PLACE D) {
    RiverPlace p = river_place(D);
    TerrainCut cut = TerrainCut(-terrain_table.rivers.base_m, 1.0, 0.0, 0.0, 0.0, vec3(0.0), vec3(0.0), vec3(0.0));
    float total = 0.0, sum = 0.0, first = 0.0, steepest = 0.0;
    vec3 d_total = vec3(0.0), d_sum = vec3(0.0);
    int k = p.lines.x, end = p.lines.x + p.lines.y;
    if (k < end) do {
        RiverLine line = river_line(river_ends(k), p);
        float half_width = line.section.y, floor_width = line.section.w;
        cut.beside = max(cut.beside, river_wets(line));
        TerrainRiverOpenSlopes opens = terrain_river_open_slopes(line.valley_d, floor_width, line.reach);
        // Where a valley ends all but 1e-8 is left: a slope still, but no float below 1.
        if (opens.value < cut.open || opens.value == cut.open && opens.by_d > steepest) {
            steepest = opens.by_d;
            cut.reach = line.reach;
            cut.open = opens.value;
            cut.d_open = opens.by_d * line.valley_away
                + (opens.by_floor_width * line.section_step.w + opens.by_reach * line.reach_step) * line.along;
        }
        TerrainRiverRaiseSlopes raises = terrain_river_raise_slopes(line.d, line.bank, floor_width, line.reach,
            line.lake);
        if (raises.value > cut.raised) {
            cut.raised = raises.value;
            cut.d_raised = raises.by_d * line.away + raises.by_half_width * line.by_bank
                + (raises.by_floor_width * line.section_step.w + raises.by_reach * line.reach_step) * line.along;
        }
        TerrainRiverSectionSlopes section = terrain_river_section_slopes(line.d, line.bank, line.section.z);
        TerrainRiverShareSlopes share = terrain_river_share_slopes(line.d, half_width, line.reach);
        first = k == p.lines.x ? line.section.x : first;
        float own = line.section.x - first + section.value;
        total += share.value;
        sum += share.value * own;
        vec3 d_own = section.by_d * line.away + section.by_half_width * line.by_bank
            + (line.section_step.x + section.by_depth * line.section_step.z) * line.along;
        vec3 d_share = share.by_d * line.away
            + (share.by_half_width * line.section_step.y + share.by_reach * line.reach_step) * line.along;
        d_total += d_share;
        d_sum += share.value * d_own + own * d_share;
    } while (++k < end);
    if (total > 0.0) {
        float mean = sum / total;
        cut.base = first + mean;
        cut.d_base = (d_sum - mean * d_total) / total;
    }
    cut.d_base = cut.d_base * p.turned;
    cut.d_open = cut.d_open * p.turned;
    cut.d_raised = cut.d_raised * p.turned;
    return cut;
}
