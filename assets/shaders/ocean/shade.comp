// Light of the sea's pixels: what its surface mirrors (sun, sky, ground in the picture), what comes up from below, foam
// and ice.
//
//   OCEAN_RICH          bed, foam, ice: for tiles that need them (ocean/classify.comp says which)
//   OCEAN_LIMB          seen from so high and so flat that air changes within a tile
//   OCEAN_FAR           pixels too wide for the pattern of foam
//   OCEAN_GLOW          the liquid shines by itself, or has a crust
//   OCEAN_BELOW         the surface from below
//   OCEAN_RIPPLES       waves shorter than the sea's own
//   OCEAN_COVER         trees may shade it
//   OCEAN_REFLECTIONS   turns of the search for mirrored ground
#include "common/constants.glsl"
#include "common/camera.glsl"
#ifdef OCEAN_LIMB
#include "contract/air.glsl"
#endif
#ifdef OCEAN_COVER
#include "contract/cover_light.glsl"
#endif
#include "contract/waterline.glsl"
#ifdef OCEAN_BELOW
#define SHOWS_ALSO(pixel) lens_in_water(ndc_of_pixel(vec2(pixel) + 0.5))
#else
#define SHOWS_ALSO(pixel) !lens_in_water(ndc_of_pixel(vec2(pixel) + 0.5))
#endif
#include "common/surface_tiles.glsl"
#include "common/texel.glsl"
#include "contract/land_water.glsl"
#if defined(OCEAN_RICH) && defined(LAND_WATER)
#define OCEAN_LAND_WATER   // ocean/classify.comp lists its tiles as rich
#include "ocean/look/land_water.glsl"
#endif
#include "ocean/look/pixel.glsl"
#include "ocean/look/column.glsl"
#include "ocean/look/glitter.glsl"
#include "ocean/look/mirror.glsl"
#include "ocean/look/foam.glsl"
#ifdef OCEAN_GLOW
#include "ocean/look/glow.glsl"
#endif
#ifdef OCEAN_RIPPLES
#include "ocean/look/ripples.glsl"
#endif
#ifdef OCEAN_BELOW
#include "ocean/look/below.glsl"
#endif
#ifdef OCEAN_RICH
#include "ocean/look/bed.glsl"
#include "ocean/look/caustics.glsl"
#include "ocean/look/ice.glsl"
#include "ocean/look/shore.glsl"
#endif

layout(binding = 4) uniform sampler2D u_rough;   // ocean/surface.comp: slopes that pixels don't show, Jacobian

layout(binding = 7) uniform sampler2D u_light;

vec2 v_ndc;       // of the pixel at hand
float v_hidden;   // variance of slopes that it does not show


// Maps of ocean/light.comp: 0 the sun's light, on a surface across it; 1 the sky's; 2 radiance of air between the sea
// and a camera up high; the air before the sea: 3 its extinction by the metre, 4 its source.
vec3 sea_light(int kind) {
    vec2 corners = vec2(textureSize(u_light, 0) / ivec2(1, 5)),
        at = (0.5 + 0.5 * v_ndc) * frame.viewport_px / vec2(TILE_PX) + 0.5;
    return textureLod(u_light, vec2(at.x, at.y + float(kind) * corners.y) / vec2(corners.x, 5.0 * corners.y), 0.0).rgb;
}

SeaPixel pixel_at(ivec2 pixel) {
    vec3 point = position_from_depth(v_ndc, texel_at(u_depth, pixel).r);
    vec4 rough = texel_at(u_rough, pixel);
#ifdef OCEAN_LAND_WATER
    float height_m;
    land_water_set(texel_at(u_attributes, pixel).z);
    vec4 landlocked = land_water_rough(foot_offset_of(point, height_m), length(point) * frame.pixel_rad);
    rough = g_land_water ? landlocked : rough;
#endif
    SeaPixel p = sea_pixel(point, oct_decode(texel_at(u_normal, pixel).rg),
        sea_depth_decode(texel_at(u_attributes, pixel).rg), rough);
    v_hidden = rough.x + rough.y;
#ifdef OCEAN_RIPPLES
    sea_ripples(p);
#endif
    return p;
}

#ifdef OCEAN_BELOW
vec3 sea_radiance(SeaPixel p) {
    return surface_from_below(p, sea_light(0), sea_light(1));
}
#else
// From below. What enters is lost to the mirror, what leaves spreads over a wider angle: 1 / index^2. view_mu: cosine
// of the eye to the level; n_l: of the sun; facing: of the slopes that are seen.
vec3 upwelling_of(SeaPixel p, float view_mu, float n_l, float facing, vec3 sunlight, vec3 skylight) {
    float index = ocean.refractive_index, in_cosine = refracted_cosine(n_l);
    float out_cosine = refracted_cosine(clamp(facing, 0.05, 1.0));
    vec3 direct = sunlight * (n_l * (1.0 - fresnel_outside(max(n_l, 1e-3), index)));
    vec3 diffuse = skylight * (1.0 - ocean.diffuse_mirrored);
#ifdef OCEAN_RICH
    vec3 into = refract(-p.view, sea_normal_of(p.slopes.mean, p.level), 1.0 / index);
    float down = max(-dot(into, p.zenith), 0.3);
    // As if the bed were level as far as the line of sight shifts: two thirds of the depth at most.
    vec3 bed_at = p.D + (into + p.zenith * down) * min(p.depth_m / down, 60.0);
    vec3 bed = sea_bed(bed_at, p.depth_m, p.footprint_m / clamp(view_mu, 0.2, 1.0));
#ifdef OCEAN_LAND_WATER
    bed *= g_land_water ? STONES : vec3(1.0);
#endif
    direct *= water_caustics(bed_at, p.depth_m, p.footprint_m / clamp(view_mu, 0.2, 1.0));
    return direct * water_upwelling(p.depth_m, in_cosine, out_cosine, bed)
        + diffuse * water_upwelling(p.depth_m, 0.86, out_cosine, bed);
#else
    return direct * deep_upwelling(in_cosine, out_cosine) + diffuse * deep_upwelling(0.86, out_cosine);
#endif
}

vec3 sea_radiance(SeaPixel p) {
    vec3 sun = frame.sun_direction;
    vec3 v = p.view * p.level, l = sun * p.level;
    vec3 sunlight = sea_light(0), skylight = sea_light(1);
#ifdef OCEAN_COVER
    sunlight *= cover_light(p.point, 0.0);
#endif

    // Mirrored.
    float index = ocean.refractive_index;
    SlopesSeen seen = slopes_seen(p.slopes, v);
    vec2 aside = slopes_aside(v);
    float facet;
    float fresnel = fresnel_mean(p.slopes, seen, v, index, facet);
    vec2 slope = p.slopes.mean + (facet - dot(p.slopes.mean, aside)) * aside;
    vec3 normal = sea_normal_of(slope, p.level);
    float n_l = max(l.z, 0.0);
    vec3 white = ocean.foam_albedo * (sunlight * n_l + skylight) / PI;
    vec3 radiance = mirrored(p, reflect(-p.view, normal), seen.spread, sea_light(2), white) * fresnel;
    radiance += sunlight * glitter(p.slopes, seen, v, l, frame.sun_radius_rad, index);

    vec3 upwelling = upwelling_of(p, v.z, n_l, seen.facing, sunlight, skylight);
    radiance += upwelling * ((1.0 - fresnel) * ocean.per_index_squared);
#ifdef OCEAN_GLOW
    vec4 glow = liquid_glow(p);
    vec3 crust = vec3(0.04) * (sunlight * n_l + skylight) / PI;
    radiance = mix(radiance, crust, glow.a) + glow.rgb;
#endif

    float foam = whitecaps(p.D, p.footprint_m, crest_foam(p.fold, v_hidden));
#ifdef OCEAN_RICH
    foam = max(foam, shore_at(p.D, -p.depth_m, p.footprint_m * 0.1, p.footprint_m).foam);
#endif
#ifdef OCEAN_LAND_WATER
    foam = g_land_water ? land_water_foam(p.D, p.footprint_m) : foam;
#endif
#ifndef OCEAN_FAR
    foam = foam_pattern(p.D, p.footprint_m, foam);
#endif
    radiance = mix(radiance, white, foam * 0.9);
#ifdef OCEAN_RICH
    vec2 ice = sea_ice(p);
    radiance = mix(radiance, ocean.ice_albedo * ice.y * (sunlight * n_l + skylight) / PI, ice.x);
#endif
#ifdef OCEAN_LIMB
    // Triangles seen from so high lie hundreds of metres below the sea between their corners, and air is dense there.
    float sunk_m = planet.sea_level_m - p.height_m;
#ifdef OCEAN_LAND_WATER
    sunk_m = g_land_water ? 0.0 : sunk_m;
#endif
    Air between = air_from_camera(p.point + p.zenith * sunk_m);
    return radiance * between.transmittance + between.in_scatter;
#else
    vec3 left = exp(-sea_light(3) * p.distance_m);
    return radiance * left + sea_light(4) * (1.0 - left);
#endif
}
#endif

void main() {
    ivec2 first = tile_pixel();
    int turn = 0;
    do {
        ivec2 pixel = first;
        if (find_shown(pixel, turn, SURFACE_SEA)) {
            v_ndc = ndc_of_pixel(vec2(pixel) + 0.5);
            imageStore(u_radiance, pixel, vec4(sea_radiance(pixel_at(pixel)) * frame.hdr_per_radiance, 1.0));
        }
    } while (++turn < SHADE_TURNS);
}
