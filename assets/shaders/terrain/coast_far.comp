// As terrain/coast_ask.comp, from so far away that heights in float do. The few pixels that become land need more than a height:
// they are listed for coast_ask.comp.
#include "terrain/coast_pixel.glsl"
#define COAST_SECOND
#include "terrain/coast_asked.glsl"
#include "terrain/far_height.glsl"

void main() {
    ivec2 pixel;
    if (!coast_asked(pixel)) return;
    CoastPixel p = coast_pixel(pixel);
#ifdef COAST_TILES
    if (!p.open) return;
#endif
    float above = terrain_far_height(p.D, COAST_FINEST_PX * length(p.point) * frame.clock.w) - planet.sea.x;
    if (above < 0.0) coast_to_sea(pixel, p, -above);
    if (above >= 0.0 && p.surface == SURFACE_SEA) {
        uint last = atomicAdd(coast_land.count, 1u);
        coast_land.pixels[last] = uint(pixel.x) | uint(pixel.y) << 16;
        if (last % COAST_GROUP == 0u) atomicAdd(coast_land.groups[0], 1u);
    }
}
