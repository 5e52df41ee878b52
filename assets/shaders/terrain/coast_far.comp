// As terrain/coast_ask.comp, from so far away that heights in float do. The few pixels that become land need more than a height:
// they are listed for coast_ask.comp.
#include "terrain/coast_pixel.glsl"
#define COAST_SECOND
#include "terrain/coast_list.glsl"
#include "common/spread.glsl"
#include "terrain/far_height.glsl"

layout(local_size_x = 64) in;

void main() {
    uint index = spread_blocks(8u) * COAST_GROUP + gl_LocalInvocationID.x;
    if (index >= coast_list.count) return;
    uint place = coast_list.pixels[index];
    ivec2 pixel = coast_listed(place);
    CoastPixel p = coast_pixel(pixel);
    float above = terrain_far_height(p.D, COAST_FINEST_PX * length(p.point) * frame.clock.w) - planet.sea.x;
    if (above < 0.0) coast_to_sea(pixel, p, -above);
    if (above >= 0.0 && p.surface == SURFACE_SEA) {
        uint last = atomicAdd(coast_land.count, 1u);
        coast_land.pixels[last] = place;
        if (last % COAST_GROUP == 0u) atomicAdd(coast_land.groups[0], 1u);
    }
}
