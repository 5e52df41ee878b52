// What rivers make of the ground: the GPU's side of systems/terrain/rivers/. Part of terrain/height.glsl, which has the
// table and terrain_place. The texture holds, one after the other (rivers/texture.py): columns of cells along z, two to
// a texel; cells of columns, four to a texel; lines of cells, four to a texel, the widest of a cell's first, with how
// wide they are; and nodes of three texels: place and the node downstream; level, half width, depth, half width of the
// floor; reach, 1 for a lake, discharge.
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
    vec3 banks;    // octaves of the noise of banks
    mat3 by_place; // and how these change, 1/m, a column each
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
    p.banks = vec3(0.0);
    p.by_place = mat3(0.0);
    return p;
}

ivec3 river_cell(RiverPlace unbent) {
    return (unbent.steps + ivec3(floor(unbent.rest))) >> RIVER_CELL_BITS;
}

// The same, moved by so many octaves of the warp, and after all of them with the noise of banks, which is asked where
// lines are straight (systems/terrain/rivers/banks.py). One loop: where it makes no turn it costs one.
RiverPlace river_bent(RiverPlace p, TERRAIN_PLACE D, int octaves) {
    const ivec3 offsets = ivec3(RIVER_BANK_OFFSET_0, RIVER_BANK_OFFSET_1, RIVER_BANK_OFFSET_2);
    bool uneven = octaves == RIVER_BENDS && terrain_table.rivers.uneven > 0.0;
    vec3 bend = vec3(0.0), start = p.rest;
    int k = 0, turns = octaves + (uneven ? 3 : 0);
    if (turns > 0) do {
        bool bends = k < octaves;
        int octave = max(k - octaves, 0), bits = terrain_table.rivers.bank_bits[octave];
        TerrainLattice lattice = terrain_table.rivers.bends[min(k, RIVER_BENDS - 1)];
        ivec3 cell;
        vec3 fraction;
        mat3 jacobian;
        terrain_place(lattice, D, cell, fraction);
        vec3 whole = floor(p.rest), part = p.rest - whole;
        ivec3 steps = p.steps + ivec3(whole);
        float per_step = exp2(float(-bits)), amount = bends ? lattice.value : 0.0;
        cell = bends ? cell : (steps >> bits) + offsets[octave];
        fraction = bends ? fraction : (vec3(steps & ((1 << bits) - 1)) + part) * per_step;
        vec3 noise = vector_noise(cell, fraction, jacobian);
        bend += amount * noise;
        p.turned += (amount * lattice.frequency_per_m) * jacobian;
        p.rest = start + bend / terrain_table.rivers.step_m;
        vec3 slope = vec3(jacobian[0].x, jacobian[1].x, jacobian[2].x) * (per_step / terrain_table.rivers.step_m);
        bvec3 now = equal(ivec3(bends ? 3 : octave), ivec3(0, 1, 2));
        p.banks = mix(p.banks, noise.xxx, now);
        p.by_place[0] = now.x ? slope : p.by_place[0];
        p.by_place[1] = now.y ? slope : p.by_place[1];
        p.by_place[2] = now.z ? slope : p.by_place[2];
    } while (++k < turns);
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
    float bank;                   // half width between uneven banks
    vec3 by_bank;                 // how that changes with the place
    float reach, reach_step, lake, discharge;
    float d;                      // m from the line
    vec3 away;                    // unit, from the line to the place
    vec3 along;                   // change of the line's parameter, 1/m; 0 beyond its ends
    vec3 way;                     // of the whole line, m
};

vec3 river_level(vec3 v, vec3 up) { return v - up * dot(up, v); }

// What is known of a line's two nodes.
struct RiverEnds {
    ivec3 a;              // steps
    vec3 way;             // from there to b, steps
    vec4 above, below;    // at a, and downstream at b: level over the anchor's base, half width, depth, of the floor
    vec3 above_more, below_more;   // reach, 1 for a lake, discharge
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
    ends.above_more = intBitsToFloat(river_texel(nodes + 3 * node + 2).xyz);
    ends.below_more = intBitsToFloat(river_texel(nodes + 3 * a.w + 2).xyz);
    return ends;
}

RiverEnds river_ends(int index) {
    return river_ends_of(river_packed_line(index));
}

RiverLine river_line(RiverEnds ends, RiverPlace p) {
    // Steps: whole numbers of at most 24 bits.
    vec3 to_a = vec3(ends.a - p.steps), whole_way = ends.way, way = river_level(whole_way, p.up);
    float per_square = 1.0 / max(dot(way, way), 1.0), t = -dot(river_level(to_a - p.rest, p.up), way) * per_square;
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
    line.d = length(off);
    line.away = -off / max(line.d, 1e-9);
    line.section_step = ends.below - ends.above;
    line.section = ends.above + t * line.section_step;
    line.reach_step = ends.below_more.x - ends.above_more.x;
    line.reach = ends.above_more.x + t * line.reach_step;
    line.lake = ends.above_more.y * ends.below_more.y;
    line.discharge = mix(ends.above_more.z, ends.below_more.z, t);
    line.by_bank = line.section_step.y * line.along;
    line.bank = line.section.y;
    if (line.d < RIVER_BANK_FAR * line.section.y && terrain_table.rivers.uneven > 0.0) {
        TerrainRiverBankSlopes bank = terrain_river_bank_slopes(line.d, line.section.y, line.section.w,
            terrain_table.rivers.uneven, p.banks.x, p.banks.y, p.banks.z);
        line.bank = bank.value;
        line.by_bank = bank.by_d * line.away + p.by_place * vec3(bank.by_coarse, bank.by_middle, bank.by_fine)
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
        TerrainRiverOpenSlopes opens = terrain_river_open_slopes(line.d, floor_width, line.reach);
        // Where a valley ends all but 1e-8 is left: a slope still, but no float below 1.
        if (opens.value < cut.open || opens.value == cut.open && opens.by_d > steepest) {
            steepest = opens.by_d;
            cut.reach = line.reach;
            cut.open = opens.value;
            cut.d_open = opens.by_d * line.away
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
