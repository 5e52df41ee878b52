// Pixels of a block of 4 x 4 asked where they were found, in terrain/coast_find.comp: what is wide of the height function is evaluated
// once for all of them.
#include "terrain/coast_alone.glsl"
#include "terrain/height_around.glsl"

shared uint s_asked[8];

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

// Asks the pixels k whose bits are set, and says which it asked: all, or none in workgroups whose lanes would mostly wait for a few.
uint coast_here(uint pixels, ivec2 first, TerrainBroad broad, vec3 middle, float extent_m) {
    s_asked[gl_LocalInvocationIndex] = uint(bitCount(pixels));
    barrier();
    uint most = 0u, all = 0u;
    for (int lane = 0; lane < 8; ++lane) {
        most = max(most, s_asked[lane]);
        all += s_asked[lane];
    }
    if (most == 0u || 3u * all < 8u * most) return 0u;
    TerrainAround around = terrain_around(broad, middle, extent_m);
    for (uint rest = pixels; rest != 0u; rest &= rest - 1u) {
        int k = findLSB(rest);
        ivec2 pixel = first + ivec2(k & 3, k >> 2);
        CoastPixel p = coast_pixel(pixel);
        coast_by_height(pixel, p, terrain_height_around(around, p.D, COAST_FINEST_PX * length(p.point) * frame.clock.w));
    }
    return pixels;
}
