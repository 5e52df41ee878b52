// Pictures of the ground from tiles: engine/real_ground/color_ground.py, whose levels of pages lie in one texture as
// systems/terrain/real_colors.py says. A place is looked for by its direction in float, then counted from a pixel of
// the page whose own place is exact.
#include "generated/bindings.glsl"
#include "generated/terrain_table.glsl"
#include "generated/terrain_color_numbers.glsl"
#include "terrain/color_map.glsl"
#include "terrain/real_lattice.glsl"

struct ColorsLevel {
    TerrainRealLevel lattice;   // as far as places need it
    int table, mask;            // of its pages: the first word, and one less than there are
    int streamed;               // whether its pages come and go
};

// What pictures show at a place: albedo times weight, and the weight; coarse: 0 where pixels of pictures are as fine as
// the footprint, 1 where they are four times as wide or more.
struct ColorsSeen {
    vec3 albedo;
    float weight, coarse;
};

ivec2 colors_texel(int index) {
    int bits = terrain_table.color.levels;
    return ivec2(index & ((1 << bits) - 1), index >> bits);
}

int colors_word(int index) { return int(texelFetch(u_terrain_colors, colors_texel(index), 0).r); }

float colors_number(int index) { return intBitsToFloat(colors_word(index)); }

int colors_header(int k) { return COLORS_FIRST_LEVEL + COLORS_LEVEL * k; }

float colors_octave(int k) { return colors_number(colors_header(k) + 6); }

ColorsLevel colors_level(int k) {
    int word = colors_header(k);
    ColorsLevel level;
    level.lattice.across = colors_number(word);
    level.lattice.down = colors_number(word + 1);
    level.lattice.phase = vec2(colors_number(word + 2), colors_number(word + 3));
    level.lattice.per_rad = vec2(colors_number(word + 4), colors_number(word + 5));
    level.lattice.first_column = float(colors_word(word + 7));
    level.lattice.mercator = colors_word(word + 8);
    level.lattice.page_columns = colors_word(word + 9);
    level.table = colors_word(word + 10);
    level.mask = colors_word(word + 11);
    level.streamed = colors_word(word + 13);
    return level;
}

int colors_hash(ivec2 page) {
    uint found = uint(page.y) * 2654435761u ^ uint(page.x) * 2246822519u;
    found = (found ^ found >> 15) * 2654435769u;
    return int(found ^ found >> 13);
}

// The first word of a page's record; -1: there is none.
int colors_record(ColorsLevel level, ivec2 page) {
    int place = colors_hash(page) & level.mask, record = -1, tries = 0;
    do {
        record = colors_word(level.table + place);
        if (record < 0) break;
        // Read outside of the loop's condition, where Mesa 22.3 takes it for other lanes' too.
        ivec2 there = ivec2(colors_word(record + 1), colors_word(record));
        if (there == page) break;
        place = (place + 1) & level.mask;
    } while (++tries <= level.mask);
    return record;
}

// Albedo times weight, and the weight.
vec4 colors_texel_value(ivec2 at) {
    vec4 shares = unpackUnorm4x8(texelFetch(u_terrain_colors, at, 0).r);
    return vec4(shares.rgb * shares.rgb, shares.a);
}

#ifdef TERRAIN_PICTURES_STREAMED
// What a page that streams weighs between its corners. pixels: in the page.
float colors_there(int record, vec2 pixels) {
    int word = colors_word(2) + 4 * ((record - colors_word(1)) / COLORS_POOL_RECORD);
    vec4 corners = vec4(colors_number(word), colors_number(word + 1), colors_number(word + 2), colors_number(word + 3));
    vec2 t = clamp(pixels * vec2(colors_number(record + COLORS_COLUMNS), 1.0 / float(COLORS_SIDE)), 0.0, 1.0);
    t = t * t * (3.0 - 2.0 * t);
    return mix(mix(corners.x, corners.y, t.x), mix(corners.z, corners.w, t.x), t.y);
}

#endif

// One level at D, whose place is p, linear between pixels. there: below 1 where its page comes or goes or is missing.
vec4 colors_sample(ColorsLevel level, vec3 D, vec3 p, out float there) {
    there = 1.0;
    ivec2 about = real_about(level.lattice, p), page = ivec2(about.x / COLORS_SIDE, max(about.y, 0) / COLORS_SIDE);
    if (about.x < 0) page.x = -((COLORS_SIDE - 1 - about.x) / COLORS_SIDE);
    vec2 pixels = vec2(0.0);
    ivec2 cell = ivec2(0);
    float unit_m = terrain_table.fixed_unit_m;
    int record = -1, tries = 0;
    do {
        record = colors_record(level, page);
        if (record < 0) break;
#ifdef TERRAIN_PICTURES_STREAMED
        if (level.streamed != 0) {
            record = colors_word(record + 2);
            if (record < 0) {
                there = 0.0;
                break;
            }
        }
#endif
        ivec3 whole = ivec3(colors_word(record + 5), colors_word(record + 6), colors_word(record + 7));
        vec3 part = vec3(colors_number(record + 8), colors_number(record + 9), colors_number(record + 10));
        vec3 c = (vec3(whole) + part) * unit_m;
        vec3 d = (vec3(terrain_table.real.place - whole) + (terrain_table.real.part - part)) * unit_m + D;
        pixels = real_samples(level.lattice, c, d);
        cell = ivec2(floor(pixels)) + ivec2(colors_word(record + 4), colors_word(record + 3));
        // Float knows the place to some metres only: the next page may be meant.
        ivec2 beyond = ivec2(lessThan(ivec2(COLORS_SIDE - 1), cell)) - ivec2(lessThan(cell, ivec2(-1)));
        if (beyond == ivec2(0)) break;
        page += beyond;
        if (level.lattice.page_columns > 0)
            page.x = (page.x + level.lattice.page_columns) % level.lattice.page_columns;
    } while (++tries < 3);
    if (record < 0) return vec4(0.0);
    vec2 f = pixels - floor(pixels);
#ifdef TERRAIN_PICTURES_STREAMED
    if (level.streamed != 0) there = colors_there(record, vec2(cell) + f);
#endif
    int slot = colors_word(record + 2), bits = terrain_table.color.levels - COLORS_SLOT_BITS;
    ivec2 corner = ivec2(slot & ((1 << bits) - 1), slot >> bits) << COLORS_SLOT_BITS;
    ivec2 at = corner + clamp(cell + COLORS_BEFORE, ivec2(0), ivec2((1 << COLORS_SLOT_BITS) - 2));
    return mix(mix(colors_texel_value(at), colors_texel_value(at + ivec2(1, 0)), f.x),
        mix(colors_texel_value(at + ivec2(0, 1)), colors_texel_value(at + 1), f.x), f.y);
}

ColorsSeen terrain_colors(vec3 D, float footprint_rad) {
    ColorsSeen seen = ColorsSeen(vec3(0.0), 0.0, 0.0);
    vec3 p = terrain_table.up * terrain_table.radius_m + D;
    float flat_sine = max(length(p.xy) / length(p), 1e-6), rest = 1.0;
    int k = 0, count = colors_word(0);
    if (k < count) do {
        ColorsLevel finest = colors_level(k);
        int last = k + colors_word(colors_header(k) + 12) - 1, low = k;
        vec2 by_rad = finest.lattice.per_rad / vec2(flat_sine, finest.lattice.mercator != 0 ? flat_sine : 1.0);
        float pixels = footprint_rad * max(by_rad.x, by_rad.y);
        float octave = min(log2(max(pixels, 1.0)), colors_octave(last));
        while (low < last && colors_octave(low + 1) <= octave) ++low;
        float from = colors_octave(low), t = low < last ? (octave - from) / (colors_octave(low + 1) - from) : 0.0;
        vec4 found = vec4(0.0);
        // What pages that are missing leave, coarser levels show.
        float left = 1.0 - t, there;
        int level = low;
        do {
            vec4 one = colors_sample(colors_level(level), D, p, there);
            float part = left * there;
            found += part * one;
            left -= part;
            if (level == low) left += t;
        } while (++level <= last && left > 0.0);
        seen.albedo += rest * found.rgb;
        seen.coarse += rest * found.a * clamp(-0.5 * log2(max(pixels, 1e-9)), 0.0, 1.0);
        rest *= found.a > COLORS_WHOLE ? 0.0 : 1.0 - found.a;
        k = last + 1;
    } while (k < count && rest > 0.0);
    seen.weight = 1.0 - rest;
    return seen;
}
