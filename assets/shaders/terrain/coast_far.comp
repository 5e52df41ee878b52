// As terrain/coast_ask.comp, from so far away that heights in float do.
#include "terrain/coast_alone.glsl"
#include "terrain/coast_asked.glsl"
#include "terrain/far_height.glsl"

void main() {
    ivec2 pixel;
    if (!coast_asked(pixel)) return;
    CoastPixel p = coast_pixel(pixel);
    coast_by_height(pixel, p, terrain_far_height(p.D, COAST_FINEST_PX * length(p.point) * frame.pixel_rad));
}
