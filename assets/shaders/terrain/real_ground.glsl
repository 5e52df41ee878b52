// Real elevation from tiles: engine/real_ground/real_ground.py, whose levels of pages lie in one texture as
// systems/terrain/real_texture.py says. A place is looked for by its direction in float, then counted from the nearest
// of samples whose own places are exact: nothing is lost on the way to a sample's fraction.
#include "generated/bindings.glsl"
#include "generated/terrain_table.glsl"
#include "generated/terrain_real_numbers.glsl"
#include "terrain/limited_cubic.glsl"
#include "terrain/real_lattice.glsl"
#ifdef TERRAIN_ERODED
#include "terrain/gullies.glsl"
#endif

// Metres of the levels, over what heights count from, and what they leave of the ground around, 0..1. Of the ground
// that the spacing shows their gradient, and the rest with its own.
struct RealGround {
    TERRAIN_REAL height;
    float rest, seen_rest;
    vec3 d_height, d_rest;
    // the relief below the samples: its roughness with the gradient of that, and the logarithm of the samples' distance
    // in metres, times the roughness
    float rough, deep;
    vec3 d_rough;
#ifdef TERRAIN_ERODED
    // the slope of the B-spline through the samples, which gullies follow, and how it changes with the place
    vec3 falls;
    mat3 d_falls;
#endif
};

RealGround no_real_ground() {
    return RealGround(TERRAIN_NUMBER(0.0), 1.0, 1.0, vec3(0.0), vec3(0.0), 0.0, 0.0, vec3(0.0)
#ifdef TERRAIN_ERODED
        , vec3(0.0), mat3(0.0)
#endif
    );
}

int real_word(int index) {
    int bits = terrain_table.real.width_bits;
    return int(texelFetch(u_real_ground, ivec2(index & ((1 << bits) - 1), index >> bits), 0).r);
}

// The first word of a page's record; -1: there is none.
int real_record(TerrainRealLevel level, ivec2 page) {
    ivec2 at = page - level.first_block * REAL_TABLE, block = at / REAL_TABLE;
    if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(block, level.blocks))) return -1;
    int found = real_word(level.first_word + block.y * level.blocks.x + block.x);
    if (found < 0) return -1;
    at -= block * REAL_TABLE;
    int number = real_word(level.first_page + (found * REAL_TABLE + at.y) * REAL_TABLE + at.x);
    return number < 0 ? -1 : level.first_record + level.record * number;
}

// From a sample whose place is at `word` to the place D, metres; c: the sample itself.
vec3 real_offset(int word, TERRAIN_PLACE D, out vec3 c) {
    ivec3 whole = ivec3(real_word(word), real_word(word + 1), real_word(word + 2));
    vec3 part = intBitsToFloat(ivec3(real_word(word + 3), real_word(word + 4), real_word(word + 5)));
    float unit_m = terrain_table.fixed_unit_m;
    c = (vec3(whole) + part) * unit_m;
#ifdef TERRAIN_CANONICAL
    return (vec3(D.whole - whole) + (vec3(D.part >> 8) * (1.0 / 16777216.0) - part)) * unit_m;
#else
    TerrainReal real = terrain_table.real;
    return (vec3(real.place - whole) + (real.part - part)) * unit_m + D;
#endif
}

// Derivatives of columns and rows by the place p.
void real_jacobian(TerrainRealLevel level, vec3 p, out vec3 by_column, out vec3 by_row) {
    float flat2 = max(dot(p.xy, p.xy), 1e-12 * dot(p, p)), flat_m = sqrt(flat2), r2 = flat2 + p.z * p.z;
    by_column = vec3(-p.y, p.x, 0.0) * (level.per_rad.x / flat2);
    by_row = vec3(-p.xy * (p.z / flat_m), flat_m) * (-level.per_rad.y / r2);
    if (level.mercator != 0) by_row *= sqrt(r2) / flat_m;
}

// Two rows of four samples from a texel of a slot on.
void real_rows(ivec2 at, out vec4 first, out vec4 second) {
    vec2 size = vec2(textureSize(u_real_ground, 0)), corner = vec2(at + 1);
    vec4 west = uintBitsToFloat(textureGather(u_real_ground, corner / size));
    vec4 east = uintBitsToFloat(textureGather(u_real_ground, (corner + vec2(2.0, 0.0)) / size));
    first = vec4(west.wz, east.wz);
    second = vec4(west.xy, east.xy);
}

// Four rows of them, over the sample `center`.
mat4 real_around(ivec2 at, out float center) {
    vec4 r0, r1, r2, r3;
    real_rows(at, r0, r1);
    real_rows(at + ivec2(0, 2), r2, r3);
    center = r1.y;
    return mat4(r0 - center, r1 - center, r2 - center, r3 - center);
}

ivec2 real_slot(int slot) {
    int bits = terrain_table.real.width_bits - REAL_SLOT_BITS;
    return ivec2(slot & ((1 << bits) - 1), slot >> bits) << REAL_SLOT_BITS;
}

// The limited cubic at f, over the sample `center`; by: its derivatives by column and row.
float real_cubic(ivec2 at, vec2 f, out float center, out vec2 by) {
    mat4 taps = transpose(real_around(at, center));
    vec4 slope, row = taps[1] + limited_cubic(taps[0], taps[1], taps[2], taps[3], f.x, slope);
    float over = limited_cubic(row, slope, f.y, by.y, by.x);
    return row.y + over;
}

// Weights of the cubic B-spline, and their derivatives.
vec4 real_spline(float f, out vec4 slope) {
    float g = 1.0 - f;
    slope = vec4(-0.5 * g * g, f * (1.5 * f - 2.0), -g * (1.5 * g - 2.0), 0.5 * f * f);
    return vec4(g * g * g, 4.0 - f * f * (6.0 - 3.0 * f), 4.0 - g * g * (6.0 - 3.0 * g), f * f * f) / 6.0;
}

// The B-spline through weights.
float real_weight(ivec2 at, vec2 f, out vec2 by) {
    vec4 dx, dy, wx = real_spline(f.x, dx), wy = real_spline(f.y, dy);
    float center;
    mat4 rows = real_around(at, center);
    vec4 sums = wx * rows, slopes = dx * rows;
    by = vec2(dot(wy, slopes), dot(dy, sums));
    float weight = clamp(center + dot(wy, sums), 0.0, 1.0);
    return weight > 1.0 - REAL_DONE ? 1.0 : weight;
}

// The B-spline through height differences of samples, at a place in the page; by: derivatives by column and row.
float real_roughness(int record, vec2 place, out vec2 by) {
    vec2 at = place / REAL_ROUGH_SIDE + 2.0, f = at - floor(at);
    ivec2 node = clamp(ivec2(floor(at)) - 1, 0, REAL_ROUGH - 4);
    vec4 dx, dy, wx = real_spline(f.x, dx), wy = real_spline(f.y, dy), sums, slopes;
    for (int b = 0; b < 4; ++b) {
        int word = record + REAL_FIRST_NODE + (node.y + b) * REAL_ROUGH + node.x;
        vec4 row = intBitsToFloat(ivec4(real_word(word), real_word(word + 1), real_word(word + 2),
            real_word(word + 3)));
        sums[b] = dot(wx, row);
        slopes[b] = dot(dx, row);
    }
    by = vec2(dot(wy, slopes), dot(dy, sums)) / REAL_ROUGH_SIDE;
    return dot(wy, sums);
}

// One level at a place; rough: of the relief below its samples, falls: which that follows.
struct RealSample {
    TERRAIN_REAL height;
    float weight, rough;
    vec3 d_height, d_weight, d_rough;
#ifdef TERRAIN_ERODED
    vec3 falls;
    mat3 d_falls;
#endif
};

#ifdef TERRAIN_ERODED
// Derivatives of the B-spline through heights by column and row: first ones, and those by column twice, by both, by row
// twice.
void real_falls(ivec2 at, vec2 f, out vec2 by, out vec3 second) {
    vec4 dx, dy, wx = real_spline(f.x, dx), wy = real_spline(f.y, dy);
    vec4 ddx = vec4(1.0 - f.x, 3.0 * f.x - 2.0, 1.0 - 3.0 * f.x, f.x);
    vec4 ddy = vec4(1.0 - f.y, 3.0 * f.y - 2.0, 1.0 - 3.0 * f.y, f.y);
    float center;
    mat4 rows = real_around(at, center);
    vec4 sums = wx * rows, slopes = dx * rows;
    by = vec2(dot(wy, slopes), dot(dy, sums));
    second = vec3(dot(wy, ddx * rows), dot(dy, slopes), dot(ddy, sums));
}
#endif

// Between the last row and a pole all meridians come to the same height. rows: from the pole; turn: 1 at the north one.
void real_towards_pole(float rows, float width, vec2 there, float turn, inout RealSample found, inout vec2 d_height,
    inout vec2 d_weight, inout vec2 towards) {
    if (rows >= width) return;
    float t = max(rows, 0.0) / width, f = t * t * (3.0 - 2.0 * t), d_f = 6.0 * t * (1.0 - t) / width * turn;
    float pole_m = there.x - terrain_table.real.ground_m - terrain_table.real.ground_rest_m;
    TERRAIN_REAL over = TERRAIN_SUM(found.height, TERRAIN_NUMBER(-pole_m));
    towards = vec2(f, d_f);
    d_height *= f;
    d_height.y += d_f * TERRAIN_SINGLE(over);
    d_weight *= f;
    d_weight.y += d_f * (found.weight - there.y);
    found.height = TERRAIN_SUM(TERRAIN_PRODUCT(f, over), TERRAIN_NUMBER(pole_m));
    found.weight = mix(there.y, found.weight, f);
}

#ifdef TERRAIN_STREAMED
// Pages that stream weigh what they do at their corners, and between those something in between: 0 at those that a page
// beside them lacks. samples: in the page.
void real_fade(TerrainRealLevel level, int record, vec2 samples, inout RealSample found, inout vec2 d_weight) {
    int word = terrain_table.real.first_fade + (record - level.first_record) / (REAL_POOL_RECORD / 4);
    vec4 corners = intBitsToFloat(ivec4(real_word(word), real_word(word + 1), real_word(word + 2),
        real_word(word + 3)));
    vec2 per_sample = vec2(intBitsToFloat(real_word(record + REAL_AFTER_SQUARES)), 1.0 / float(REAL_PAGE));
    vec2 t = clamp(samples * per_sample, 0.0, 1.0), s = t * t * (3.0 - 2.0 * t), d_s = 6.0 * t * (1.0 - t) * per_sample;
    float north = corners.x + (corners.y - corners.x) * s.x, south = corners.z + (corners.w - corners.z) * s.x;
    float part = north + (south - north) * s.y;
    float by_x = (corners.y - corners.x) + ((corners.w - corners.z) - (corners.y - corners.x)) * s.y;
    d_weight = d_weight * part + found.weight * vec2(by_x, south - north) * d_s;
    found.weight *= part;
}

#endif

// Whether a level has anything at D, whose place is p. rough: whether its relief's roughness is asked for.
bool real_sample(TerrainRealLevel level, TERRAIN_PLACE D, vec3 p, bool rough, out RealSample found) {
    ivec2 about = real_about(level, p), page = ivec2(about.x / REAL_PAGE, max(about.y, 0) / REAL_PAGE);
    ivec2 cell = about - page * REAL_PAGE;
    if (about.x < 0) page.x = -((REAL_PAGE - 1 - about.x) / REAL_PAGE);
    cell.x = about.x - page.x * REAL_PAGE;
    vec2 samples = vec2(0.0);
    vec3 c;
    int record = -1, tries = 0, squares = REAL_PAGE / level.near;
    do {
        record = real_record(level, page);
        if (record < 0) return false;
        ivec2 square = clamp(cell / level.near, 0, squares - 1);
        int near = record + REAL_FIRST_SQUARE + (square.y * squares + square.x) * REAL_PLACE;
        vec3 d = real_offset(near, D, c);
        samples = real_samples(level, c, d);
        cell = ivec2(floor(samples)) + ivec2(real_word(near + 7), real_word(near + 6));
        // Float knows the place to some metres only: the next page may be meant.
        ivec2 beyond = ivec2(lessThan(ivec2(REAL_PAGE + 2), cell)) - ivec2(lessThan(cell, ivec2(-2)));
        if (beyond == ivec2(0)) break;
        page += beyond;
        cell -= beyond * REAL_PAGE;
        if (level.page_columns > 0) page.x = (page.x + level.page_columns) % level.page_columns;
    } while (++tries < 3);
    vec2 f = samples - floor(samples), d_height, d_weight = vec2(0.0);
    ivec2 at = clamp(cell + REAL_BEFORE - 1, 0, (1 << REAL_SLOT_BITS) - 4);
    float center, over = real_cubic(real_slot(real_word(record)) + at, f, center, d_height);
    found.height = TERRAIN_SUM(TERRAIN_NUMBER(center - terrain_table.real.ground_m),
        TERRAIN_NUMBER(over - terrain_table.real.ground_rest_m));
    found.weight = 1.0;
    int weights = real_word(record + 1);
    if (weights >= 0) found.weight = real_weight(real_slot(weights) + at, f, d_weight);
    vec2 towards = vec2(1.0, 0.0);   // 0 at a pole, and its derivative by row
    if (level.mercator == 0) {
        float row = float(real_word(record + 2)) + float(cell.y) + f.y + level.phase.y;
        float width = level.phase.y > 0.0 ? level.phase.y : 1.0;
        real_towards_pole(row, width, level.polar.xy, 1.0, found, d_height, d_weight, towards);
        real_towards_pole(level.down - row, width, level.polar.zw, -1.0, found, d_height, d_weight, towards);
    }
#ifdef TERRAIN_STREAMED
    if (level.streamed != 0) real_fade(level, record, vec2(cell) + f, found, d_weight);
#endif
    vec3 by_column, by_row;
    real_jacobian(level, p, by_column, by_row);
    found.d_height = d_height.x * by_column + d_height.y * by_row;
    found.d_weight = d_weight.x * by_column + d_weight.y * by_row;
    found.rough = 0.0;
    found.d_rough = vec3(0.0);
#ifdef TERRAIN_ERODED
    found.falls = vec3(0.0);
    found.d_falls = mat3(0.0);
#endif
    if (rough && terrain_table.real.rough != 0) {
        vec2 by;
        float differ = real_roughness(record, vec2(cell) + f, by);
        by = by * towards.x + vec2(0.0, differ * towards.y);
        found.rough = level.rough_per_m * differ * towards.x;
        if (found.rough < REAL_MOST_ROUGH) found.d_rough = level.rough_per_m * (by.x * by_column + by.y * by_row);
        found.rough = min(found.rough, REAL_MOST_ROUGH);
#ifdef TERRAIN_ERODED
        vec3 second;
        real_falls(real_slot(real_word(record)) + at, f, by, second);
        by *= towards.x;
        second *= towards.x;
        found.falls = by.x * by_column + by.y * by_row;
        found.d_falls = outerProduct(second.x * by_column + second.y * by_row, by_column)
            + outerProduct(second.y * by_column + second.z * by_row, by_row);
#endif
    }
    return true;
}

// How much of a level's gradient is seen at a spacing.
float real_share(TerrainRealLevel level, float spacing_m) {
    if (level.octaves == 0.0) return 1.0;
    return clamp(1.0 - log2(REAL_LEVEL_SAMPLES * spacing_m / level.sample_m) / level.octaves, 0.0, 1.0);
}

#ifdef TERRAIN_STREAMED
float real_height_share(TerrainRealLevel level, float spacing_m) {
    return level.streamed != 0 ? real_share(level, REAL_HEIGHTS_FINER * spacing_m) : 1.0;
}
#else
float real_height_share(TerrainRealLevel level, float spacing_m) {
    return 1.0;
}
#endif

// Share of a layer of relief below samples: 1 where it is shorter than two of them, 0 from four on.
float real_below(RealGround real, float wavelength_m) {
    float sample_m = exp2(real.deep / max(real.rough, 1e-20));
    return 1.0 - clamp((wavelength_m / sample_m - 2.0) / 2.0, 0.0, 1.0);
}

// Metres of the layers that no warp bends, below the samples; slope: their gradient as the spacing shows it. up: of the
// place.
float terrain_real_relief(RealGround real, TERRAIN_PLACE D, vec3 up, float spacing_m, out vec3 slope) {
    slope = vec3(0.0);
    float sum = 0.0, seen = 0.0;
    int end = real.rough > 0.0 ? terrain_shown_layers(spacing_m) : 0, i = terrain_table.warped_layers;
#ifdef TERRAIN_ERODED
    float part = 1.0 / max(1.0 - real.rest, REAL_DONE);
    Gullies gullies = Gullies(real.falls * part, real.d_falls * part, up, real.rough, terrain_table.erosion, 0.0, 0.0,
        vec3(0.0));
#endif
    if (i < end) do {
        TerrainLayer layer = terrain_table.layers[i];
        ivec3 cell;
        vec3 fraction;
        terrain_place(layer.lattice, D, cell, fraction);
        vec4 n = gradient_noise(cell, fraction);
        float whole = layer.amplitude_m * real_below(real, layer.lattice.wavelength_m);
        float weight = terrain_layer_weight(layer.lattice.wavelength_m, spacing_m);
        float value = terrain_ridge(n.w, layer.ridge);
        vec3 by = (layer.lattice.frequency_per_m * terrain_ridge_slope(n.w, layer.ridge)) * n.xyz;
#ifdef TERRAIN_ERODED
        if (i < GULLY_END_BELOW_SAMPLES && whole > 0.0) {
            Gully gully = gully_layer(cell, fraction, layer.lattice.wavelength_m, whole, mat3(1.0), gullies);
            by = mix(by, gully.d_wave, gully.share) + gully.d_share * (gully.wave - value);
            value = mix(value, gully.wave, gully.share);
        }
#endif
        sum += whole * value * terrain_height_weight(layer.lattice.wavelength_m, spacing_m);
        seen += whole * value * weight;
        slope += (whole * weight) * by;
    } while (++i < end);
    slope = real.rough * slope + seen * real.d_rough;
    return real.rough * sum;
}

// heights: else only what the spacing shows is looked at, `rest` is `seen_rest`, and of relief it is known only that it
// begins below the finest samples of a set.
RealGround real_composed(TERRAIN_PLACE D, float spacing_m, bool heights) {
    RealGround sum = no_real_ground();
    sum.rest = heights ? 1.0 : 0.0;
    vec3 p = terrain_table.up * terrain_table.radius_m + terrain_offset(D);
    int k = 0, levels = terrain_table.real.levels;
    if (k < levels) do {
        TerrainRealLevel level = terrain_table_real_levels(k);
        float share = sum.seen_rest > 0.0 ? real_share(level, spacing_m) : 0.0;
        float high = heights ? real_height_share(level, spacing_m) : 1.0;
        RealSample found;
        if ((sum.rest * high > 0.0 || share > 0.0) && real_sample(level, D, p, heights, found)) {
            float part = heights ? sum.rest * high * found.weight : sum.seen_rest * share * found.weight;
            sum.height = TERRAIN_SUM(sum.height, TERRAIN_PRODUCT(part, found.height));
            float steep = heights ? found.rough : 1.0;
            sum.rough += part * steep;
            sum.deep += part * steep * log2(heights ? level.sample_m : level.finest_m);
            sum.d_rough += part * found.d_rough;
#ifdef TERRAIN_ERODED
            sum.falls += part * found.falls;
            sum.d_falls += part * found.d_falls;
#endif
            sum.rest *= 1.0 - high * found.weight;
            float weight = share * found.weight, kept = sum.seen_rest, h = TERRAIN_SINGLE(found.height);
            vec3 d_weight = share * found.d_weight;
            sum.d_height += (sum.d_rest * weight + kept * d_weight) * h + kept * weight * found.d_height;
            sum.d_rest = sum.d_rest * (1.0 - weight) - kept * d_weight;
            sum.seen_rest = kept * (1.0 - weight);
            if (sum.rest < REAL_DONE) sum.rest = 0.0;
            if (sum.seen_rest < REAL_DONE) {
                sum.seen_rest = 0.0;
                sum.d_rest = vec3(0.0);
            }
        }
    } while (++k < levels && (sum.rest > 0.0 || sum.seen_rest > 0.0));
    if (!heights) sum.rest = sum.seen_rest;
    return sum;
}

RealGround terrain_real(TERRAIN_PLACE D, float spacing_m) { return real_composed(D, spacing_m, true); }

#ifndef TERRAIN_CANONICAL
// What pixels show of real ground; nothing where vertices spacing_m apart show all of it, and all that they leave out
// is shorter than its samples. longest_m: of the layers that pixels add.
RealGround terrain_real_seen(vec3 D, float spacing_m, float footprint_m, float longest_m) {
    float finest_m = terrain_table_real_levels(0).sample_m;
    float alike_m = 2.0 * finest_m;
#ifdef TERRAIN_ERODED
    // There are gullies of lengths that the ground around has none of.
    float first_m = terrain_table.layers[0].lattice.wavelength_m;
    alike_m = min(alike_m, first_m * exp2(-float(GULLY_END_BELOW_SAMPLES - 1)));
#endif
    if (REAL_LEVEL_SAMPLES * spacing_m <= finest_m && longest_m <= alike_m) return no_real_ground();
    return real_composed(D, footprint_m, false);
}

// What pixels show beyond the vertices' gradient, `rises`, of ground at height_m; tangential. fine: for the pixel's
// footprint. Where vertices are further apart than samples, and all is real ground, they know nothing that it lacks.
vec3 terrain_real_detail(RealGround fine, vec3 D, float spacing_m, float height_m, vec3 rises) {
    float finest_m = terrain_table_real_levels(0).sample_m;
    if (REAL_LEVEL_SAMPLES * spacing_m <= finest_m || fine.rest == 1.0) return vec3(0.0);
    vec3 up = terrain_table.up + D / terrain_table.radius_m, found = vec3(0.0);
    float whole = fine.rest == 0.0 ? clamp(spacing_m / finest_m - 1.0, 0.0, 1.0) : 0.0;
    if (whole < 1.0) {
        RealGround coarse = real_composed(D, spacing_m, false);
        found = fine.d_height - coarse.d_height + height_m * (fine.d_rest - coarse.d_rest);
    }
    found = mix(found, fine.d_height - rises, whole);
    return found - up * dot(up, found);
}
#endif
