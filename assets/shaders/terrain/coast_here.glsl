// Pixels of a block of 4 x 4 asked where they were found, in terrain/coast_find.comp: what is wide of the height
// function is evaluated once for all of them.
//
// Where only every second pixel is shaded, as the squares of a checkerboard, the others are filled in from those
// around: of a pair of a black square and a white one the white is asked only if it is to be shaded itself, because the
// black one shows something else.
#include "terrain/coast_alone.glsl"
#include "terrain/height_around.glsl"

shared uint s_asked[8];
uniform int u_checkerboard;   // that are shaded, as frame.checkerboard has them; -1 all

// Of a block's pixels k, bits: that show land or water, that show water as far as is known yet, and of which that will
// stay so.
struct CoastDrawn {
    uint either, sea, stays;
};

void coast_drawn(inout CoastDrawn drawn, int k, uint surface, bool kept, bool known, bool deep) {
    drawn.either |= surface == SURFACE_TERRAIN || surface == SURFACE_SEA ? 1u << k : 0u;
    drawn.sea |= (known && !kept ? deep : surface == SURFACE_SEA) ? 1u << k : 0u;
    drawn.stays |= known || kept ? 1u << k : 0u;
}

// The other pixel of each one's pair.
uint coast_other(uint pixels) {
    return (pixels & 0x5555u) << 1 | pixels >> 1 & 0x5555u;
}

vec3 coast_corner(ivec2 pixel, inout bool there) {
    float depth = texel_at(u_depth, pixel).r, drawn;
    there = there && depth > 0.0;
    return foot_offset_of(position_from_depth(ndc_of_pixel(vec2(pixel) + 0.5), max(depth, 1e-30)), drawn);
}

// How far from their middle pixels of a block may be for that, in metres; -1 where it has no middle or is too wide.
float coast_extent(ivec2 first, ivec2 last, inout vec3 middle) {
    bool there = true;
    vec3 a = coast_corner(min(first, last), there), b = coast_corner(min(first + ivec2(3, 0), last), there);
    vec3 c = coast_corner(min(first + ivec2(0, 3), last), there), d = coast_corner(min(first + 3, last), there);
    if (!there) return -1.0;
    middle = 0.25 * (a + b + c + d);
    float extent_m = max(max(length(a - middle), length(b - middle)), max(length(c - middle), length(d - middle)));
    return terrain_keeps_around(extent_m) ? 1.001 * extent_m : -1.0;
}

// Asks the pixels of these bits; of which that are below the sea's level.
uint coast_ask_each(uint pixels, ivec2 first, TerrainAround around) {
    uint sea = 0u;
    for (; pixels != 0u; pixels &= pixels - 1u) {
        int k = findLSB(pixels);
        ivec2 pixel = first + ivec2(k & 3, k >> 2);
        CoastPixel p = coast_pixel(pixel);
        float height = terrain_height_around(around, p.D, COAST_FINEST_PX * length(p.point) * frame.pixel_rad);
        coast_by_height(pixel, p, height);
        sea |= height < planet.sea_level_m ? 1u << k : 0u;
    }
    return sea;
}

// Asks the pixels k whose bits are set, and says which are done with: all, or none in workgroups whose lanes would
// mostly wait for a few.
uint coast_here(uint pixels, CoastDrawn drawn, ivec2 first, TerrainBroad broad, vec3 middle, float extent_m) {
    s_asked[gl_LocalInvocationIndex] = uint(bitCount(pixels));
    barrier();
    uint most = 0u, total = 0u;
    for (int lane = 0; lane < 8; ++lane) {
        most = max(most, s_asked[lane]);
        total += s_asked[lane];
    }
    if (most == 0u || 3u * total < 8u * most) return 0u;
    TerrainAround around = terrain_around(broad, middle, extent_m);
    uint blacks = u_checkerboard < 0 ? 0xffffu : u_checkerboard == 0 ? 0xa5a5u : 0x5a5au, asked = pixels & blacks;
    uint sea = drawn.sea & ~asked | coast_ask_each(asked, first, around);
    // Whites whose black square shows the same, and will.
    uint alike = drawn.either & (drawn.stays | asked) & ~(sea ^ coast_other(drawn.sea));
    coast_ask_each(pixels & ~blacks & ~coast_other(alike), first, around);
    return pixels;
}
