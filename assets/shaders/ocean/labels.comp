// Albedo and material of the water, for programs: what comes up from below through its surface, as of a sky that is
// equally bright all over, foam and ice. What the surface mirrors is no part of it.
#define OCEAN_RICH 1
#define main light_sea
#include "ocean/shade.comp"
#undef main
#include "generated/material_ids.glsl"

const float DIFFUSE_COSINE = 0.86;   // of diffuse light below the surface, as in ocean/shade.comp

void main() {
    ivec2 pixel = tile_pixel();
    if (any(greaterThanEqual(pixel, textureSize(u_surface, 0))) || texel_at(u_surface, pixel).r != SURFACE_SEA) return;
    v_ndc = ndc_of_pixel(vec2(pixel) + 0.5);
    SeaPixel p = pixel_at(pixel);
    vec3 bed = sea_bed(p.D, p.depth_m, p.footprint_m);
    uint number = MATERIAL_WATER;
    float foam = whitecaps(p.D, p.footprint_m, crest_foam(p.fold, v_hidden));
    foam = max(foam, shore_at(p.D, -p.depth_m, p.footprint_m * 0.1, p.footprint_m).foam);
#ifdef OCEAN_LAND_WATER
    bed *= g_land_water ? STONES : vec3(1.0);
    foam = g_land_water ? land_water_foam(p.D, p.footprint_m) : foam;
    number = g_land_water ? MATERIAL_FRESH_WATER : number;
#endif
    vec3 albedo = water_upwelling(p.depth_m, DIFFUSE_COSINE, DIFFUSE_COSINE, bed)
        * (PI * (1.0 - ocean.diffuse_mirrored) * ocean.per_index_squared);
    albedo = mix(albedo, ocean.foam_albedo, 0.9 * foam_pattern(p.D, p.footprint_m, foam));
    vec2 ice = sea_ice(p);
    albedo = mix(albedo, ocean.ice_albedo * ice.y, ice.x);
    if (ice.x > 0.5) number = MATERIAL_ICE;
    imageStore(u_radiance, pixel, vec4(clamp(albedo, 0.0, 1.0), float(number)));
}
