// The line between land and water, pixel by pixel: the meshes meet along straight edges some pixels long, the height function
// knows better. Pixels change sides in the G-buffer before anything is shaded. terrain/coast_find.comp lists them.
#include "terrain/coast_pixel.glsl"
#include "terrain/coast_list.glsl"
#include "common/spread.glsl"

layout(local_size_x = 64) in;

void main() {
    uint index = spread_blocks(8u) * COAST_GROUP + gl_LocalInvocationID.x;
    if (index >= coast_list.count) return;
    ivec2 pixel = coast_listed(coast_list.pixels[index]);
    CoastPixel p = coast_pixel(pixel);
    TerrainPoint terrain = terrain_point(p.D, COAST_FINEST_PX * length(p.point) * frame.clock.w);
    float height = frame.anchor_up.w + terrain.dh, above = height - planet.sea.x, spacing = vertex_spacing(p.D, p.code);
    if (above < 0.0) coast_to_sea(pixel, p, -above);
    else if (p.surface == SURFACE_SEA) coast_to_land(pixel, p, terrain.gradient, above, terrain_attributes(terrain, height, spacing).xyz);
}
