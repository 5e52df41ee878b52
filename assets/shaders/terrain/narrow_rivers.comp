// Rivers too narrow for the picture's pixels, over ground that is shaded for each block of 2 x 2 alone: each pixel gets
// its own share of their water, or they would be rows of dashes. Runs over the tiles of which terrain/land_water.comp
// found some to be partly water, when the pixels between have their light.
#undef SHADE_EVERY
#include "common/surface_tiles.glsl"
#include "terrain/height.glsl"
#include "terrain/spot.glsl"
#include "contract/air.glsl"
#include "contract/sun_visibility.glsl"
#include "contract/water.glsl"
#include "terrain/narrow_water.glsl"

void main() {
    ivec2 pixel = tile_pixel();
    if (!shows(pixel, SURFACE_TERRAIN)) return;
    NarrowWater narrow = narrow_water(pixel);
    if (narrow.coverage <= 0.0) return;
    v_ndc = ndc_of_pixel(vec2(pixel) + 0.5);
    Spot s = spot_at(pixel, texel_at(u_attributes, pixel));
    Air between = air_from_camera(s.place);
    vec3 beam = frame.sun_irradiance * light_visibility(s.point).x * air_to_space(s.place, frame.sun_direction);
    WaterLight water = water_light(s.D, s.zenith, s.height_m, s.footprint_m);
    vec3 river = between.in_scatter + between.transmittance
        * narrow_water_light(narrow, s.place, s.zenith, s.view, beam * water.sun);
    vec3 seen = imageLoad(u_radiance, pixel).rgb;
    imageStore(u_radiance, pixel, vec4(mix(seen, river * frame.hdr_per_radiance, narrow.coverage), 1.0));
}
