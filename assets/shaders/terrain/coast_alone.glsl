// What a pixel becomes by its height alone. The few that become land need more than a height: they are listed for
// terrain/coast_ask.comp.
#define COAST_SECOND
#include "terrain/coast_pixel.glsl"
#include "terrain/coast_list.glsl"

void coast_by_height(ivec2 pixel, CoastPixel p, float height) {
    float above = height - planet.sea_level_m;
    if (above < 0.0) coast_to_sea(pixel, p, -above);
    if (above >= 0.0 && p.surface == SURFACE_SEA) {
        uint last = atomicAdd(coast_land.count, 1u);
        coast_land.pixels[last] = uint(pixel.x) | uint(pixel.y) << 16;
        if (last % COAST_GROUP == 0u) atomicAdd(coast_land.groups[0], 1u);
    }
}
