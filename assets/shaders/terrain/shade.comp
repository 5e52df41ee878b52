// Materials and light of the ground, once per pixel: the vertices' normal, continued by the layers below their spacing.
// Far away, where a triangle's chord cuts kilometres below the sphere, heights come from the vertices.
//
//   GROUND_CLUTTER   ground so near that things that stand on it show
//   GROUND_DRY       no pixel has water over it, or is wet from it (terrain/list_wet.comp says where)
//   GROUND_COVER     trees stand on it: the distance up to which they do, metres
//   COVER_SHRINKS    solid trees shrink where crowns of a forest (terrain/crowns.glsl) take over
//   COVER_CROWNS     those may show: how many slabs of cells a ray is followed through
//   GROUND_RIVERS    rivers and lakes: their banks, and water too narrow for a pixel
#include "common/constants.glsl"
#include "common/camera.glsl"
#include "common/texel.glsl"
#include "common/octahedral.glsl"
#include "common/surface_tiles.glsl"
#include "terrain/spot.glsl"
#include "terrain/height.glsl"
#include "terrain/attributes.glsl"
#include "terrain/material.glsl"
#ifdef GROUND_COVER
#include "contract/cover_light.glsl"
#endif
#ifdef GROUND_CLUTTER
#include "terrain/clutter.glsl"
#include "terrain/ripples.glsl"
#endif
#include "terrain/color_map.glsl"
#ifdef TERRAIN_PICTURED
#include "terrain/real_colors.glsl"
#endif
#ifdef TERRAIN_WOODED
#include "terrain/woods.glsl"
#endif
#include "contract/air.glsl"
#include "contract/sky.glsl"
#include "contract/skylight.glsl"
#include "contract/sun_visibility.glsl"
#ifdef GROUND_DRY
#include "common/water.glsl"
#else
#include "contract/water.glsl"
#endif

#ifdef GROUND_RIVERS
#include "terrain/narrow_water.glsl"
#endif

const float STARLIGHT = 1.5e-8;   // of the sun's irradiance: 2e-3 lx of stars and airglow on a moonless night

// Chosen by eye.
const vec2 TREES_FROM_M = vec2(10.0, 25.0);     // heights of the camera above the ground between which trees appear
const float LEDGES = 0.6;                       // how much steeper hard layers of rock are than others
const float NEIGHBOURS_LIT = 0.6;               // share of neighbouring ground that throws light at a slope

// Reflected radiance per irradiance at normal incidence and albedo. Lambert's law, or for dust without air McEwen's
// 1991 mixture of it with Lommel and Seeliger's law, which makes the full disc flat; L falls with the phase angle (a
// fit in sin(phase / 2) to McEwen 1996, who gives a polynomial for the moon).
float reflected(float n_l, float n_v, vec3 view, vec3 sun) {
    float half_sine = sqrt(max(0.5 - 0.5 * dot(view, sun), 0.0));
    float share = terrain_material_block.dust_law * max(1.0 - 1.15 * half_sine, 0.0);
    float seeliger = 2.0 * n_l / max(n_l + max(n_v, 0.0), 1e-3);
    return mix(n_l, seeliger, share) / PI;
}

#ifdef GROUND_CLUTTER
// Albedo of what stands on the ground: stones of both colours of rock, plants of those around, bushes of forest.
vec3 clutter_albedo(GroundClutter clutter, vec3 plant) {
    vec3 stone = mix(ROCK_ALBEDO, STRATA_ALBEDO, 0.3 + 0.3 * clutter.tint) * (1.0 + 0.35 * clutter.tint);
    vec3 tree = FOREST_ALBEDO * (1.5 + 0.5 * clutter.tint);
    vec3 leaves = mix(plant * (1.15 + 0.3 * clutter.tint), tree, clutter.bush);
    vec3 straw = 0.8 * GRASS_ALBEDO + 0.25 * DRY_ALBEDO;
    leaves = mix(leaves, straw, clamp(clutter.dry, 0.0, 1.0)) * (1.0 - clutter.bloomed) + clutter.bloom;
    return mix(stone, leaves * clutter.light, clutter.plant);
}
#endif

#ifdef TERRAIN_PICTURED
// The pictures' colour, over the materials'. Where its pixels are wider than those of the view it is broken up as that
// of a map of all the planet.
vec3 pictured(Material material, Ground ground, vec3 D) {
    ColorsSeen seen = terrain_colors(D, ground.footprint_m / planet.radius_m);
    if (seen.weight <= 0.0) return material.albedo;
    float coarse = seen.coarse / seen.weight, variation = terrain_material_block.variation;
    vec3 color = seen.albedo / seen.weight;
    color *= 1.0 + coarse * variation * (0.12 * ground.fine + 0.08 * ground.broad);
    float rock = dot(ROCK_ALBEDO, vec3(1.0)), level = max(dot(DRY_ALBEDO, vec3(1.0)), 1e-3);
    color *= mix(1.0, clamp(rock / level, 0.6, 1.6), 0.7 * coarse * material.rock);
    color = mix(color, material.albedo, 0.5 * coarse * ramp(30.0, 0.5, ground.footprint_m));
    return clamp(mix(material.albedo, color, seen.weight * terrain_table.color.strength), 0.0, 1.0);
}
#endif

#ifdef TERRAIN_COLORED
// The map's colour, broken up by the materials' noise, rock and freshly dug ground; near the eye half of the materials'
// own.
vec3 colored(Material material, Ground ground, vec3 zenith) {
    vec3 color = terrain_color(zenith, terrain_table.color, ground.footprint_m / planet.radius_m);
    float variation = terrain_material_block.variation;
    color *= 1.0 + variation * (0.12 * ground.fine + 0.08 * ground.broad);
    float rock = dot(ROCK_ALBEDO, vec3(1.0)), level = max(dot(DRY_ALBEDO, vec3(1.0)), 1e-3);
    color *= mix(1.0, clamp(rock / level, 0.6, 1.6), 0.7 * material.rock);
    color *= 1.0 + 0.35 * clamp((TERRAIN_COLORED_MOISTURE - ground.moisture) / TERRAIN_DUG_DRY, 0.0, 1.5);
    color = mix(color, material.albedo, 0.5 * ramp(30.0, 0.5, ground.footprint_m));
    return clamp(mix(material.albedo, color, terrain_table.color.strength), 0.0, 1.0);
}
#endif

// Water over the ground, and ground that is wet from it. gradient: with all that shows of it.
WaterLight ground_water(Spot s, vec3 gradient, inout Material material, out Shore wet) {
    float rise_m = s.footprint_m * max(length(gradient), 0.02);
    wet = shore(s.D, s.height_m, rise_m, s.footprint_m);
    material.albedo *= mix(vec3(1.0), WETTED, wet.damp);
    material.albedo = mix(material.albedo, wet.foam_albedo, wet.foam);
    return water_light(s.D, s.zenith, s.height_m, s.footprint_m);
}

#ifdef GROUND_CLUTTER
// What stands on the ground: its albedo and normal, and how much it leaves open of sun and sky. rises: the vertices'
// gradient; gradient: with all that shows.
void stand_clutter(
    Spot s, vec3 sun, Ground ground, vec3 rises, vec3 gradient, inout Material material, inout vec3 normal,
    inout vec2 open
) {
    material.growth.trees *= ramp(TREES_FROM_M.x, TREES_FROM_M.y, s.distance_m * dot(s.view, s.zenith));
    GroundClutter clutter = ground_clutter(s.point, s.D, s.zenith, levelled(s.view, s.coarse, s.zenith),
        levelled(sun, s.coarse, s.zenith), s.across_m, material.stony, material.growth, ground.above_sea_m,
        ground.beach_height_m, rises);
    material.albedo = mix(material.albedo, clutter_albedo(clutter, material.plant), clutter.cover);
    normal = normalize(normal * (1.0 - clutter.cover) + clutter.normal - gradient * dot(clutter.normal, s.zenith));
    open *= mix(vec2(clutter.sun, clutter.sky), vec2(1.0), clutter.cover);
}
#endif

#ifdef GROUND_COVER
#include "terrain/forest.glsl"
#endif

// Radiance that the ground throws back. beam: the sun's irradiance in the air; open: shares of sun and sky that nothing
// hides; hidden_slope: of relief that the pixel hides.
vec3 ground_light(Spot s, vec3 albedo, vec3 normal, vec3 beam, WaterLight water, vec2 open, float hidden_slope) {
    // Mean over the slopes that a pixel hides: max(x, 0) turns into a soft bend as wide as they spread.
    float mu = dot(normal, water.to_sun), soft = 0.5 * hidden_slope;
    float n_l = 0.5 * (mu + sqrt(mu * mu + soft * soft))
        - 0.5 * soft * clamp(1.0 - mu / max(soft, 1e-4), 0.0, 1.0) * 0.5;
    vec3 sunlight = beam * water.sun;
    // Light that lit neighbouring ground throws back: without it the airless dark sides would be pure black.
    float sun_height = max(dot(s.zenith, water.to_sun), 0.0);
    vec3 bounce = albedo * sunlight * sun_height * (0.5 - 0.5 * dot(normal, s.zenith)) * NEIGHBOURS_LIT;
    vec3 irradiance = (skylight(s.place, normal) * water.sky + bounce + frame.sun_irradiance * STARLIGHT) * open.y;
    return albedo * (sunlight * reflected(max(n_l, 0.0), dot(normal, s.view), s.view, water.to_sun) + irradiance / PI);
}

// What is there, before any light.
struct Shown {
    Ground ground;
    Material material;
    vec3 rises, gradient;   // the vertices' gradient; with all that shows of it
};

Shown ground_shown(Spot s, vec4 attributes, ivec2 pixel) {
    float roughness = terrain_roughness(attributes), moisture = attributes.y;
    vec3 rises = s.zenith - s.coarse / max(dot(s.coarse, s.zenith), 0.05), gradient = rises;

#ifdef TERRAIN_TILED
    RealGround real = terrain_real_seen(s.D, s.spacing_m, s.footprint_m,
        4.0 * max(s.spacing_m, DETAIL_FINE * s.footprint_m));
#endif
    GroundDetail detail = ground_detail(s.D, roughness, s.spacing_m, s.footprint_m
#ifdef TERRAIN_ERODED
        , rises, s.zenith
#endif
#ifdef TERRAIN_TILED
        , real
#endif
    );
    vec3 relief = roughness * s.to_sphere * detail.gradient;
    gradient += relief - s.zenith * dot(s.zenith, relief);
    TerrainSources craters = terrain_crater_detail(s.D, s.spacing_m, s.footprint_m);
    gradient += s.to_sphere * (craters.gradient + terrain_mapped_detail(s.D, s.spacing_m, s.footprint_m));
#ifdef TERRAIN_TILED
    gradient += s.to_sphere * terrain_real_detail(real, s.D, s.spacing_m, s.height_m - frame.anchor_height_m,
        rises / s.to_sphere);
#endif
    moisture = max(moisture - TERRAIN_DUG_DRY * craters.dug, 0.0);
    ground_cliffs(detail, s.D + s.height_m * s.zenith, length(gradient), s.footprint_m);
    float wooded = 1.0;
#ifdef TERRAIN_WOODED
    wooded = terrain_wooded(s.D, s.footprint_m);
#endif
    Ground ground = ground_at(detail, s.zenith, s.height_m, gradient, roughness, moisture, s.footprint_m, wooded);
#ifdef GROUND_RIVERS
    NarrowWater banks = narrow_water(pixel);
    ground.barred = banks.barred;
    ground.silted = land_water_silt(banks.muddy);
#endif
    Material material = terrain_material(ground);
#ifdef GROUND_COVER
    material.inland *= wooded;
#endif
#ifdef TERRAIN_COLORED
    if (terrain_table.color.cells > 0)
        material.albedo = colored(material, ground, s.zenith);
#endif
#ifdef TERRAIN_PICTURED
    material.albedo = pictured(material, ground, s.D);
#endif
    gradient *= 1.0 + LEDGES * material.rock * ground.layered;
    vec3 bumps = material.grain * detail.grain;
#ifdef GROUND_CLUTTER
    // No wind without air.
    vec4 rippled = ripples(s.D, material.ripples.octave, material.ripples.bend, s.footprint_m)
        * (material.ripples.share * (1.0 - terrain_material_block.dust_law));
    bumps += material.ripples.slope * terrain_material_block.clutter * rippled.xyz;
    material.albedo *= 1.0 + material.ripples.tint * rippled.w;
#endif
    gradient += bumps - s.zenith * dot(s.zenith, bumps);
    return Shown(ground, material, rises, gradient);
}

vec3 ground_radiance(ivec2 pixel) {
    vec4 attributes = texel_at(u_attributes, pixel);
    Spot s = spot_at(pixel, attributes);
    Shown shown = ground_shown(s, attributes, pixel);
    Ground ground = shown.ground;
    Material material = shown.material;
    vec3 gradient = shown.gradient;
    vec3 normal = normalize(s.zenith - gradient);

    Shore wet;
    WaterLight water = ground_water(s, gradient, material, wet);
#ifdef GROUND_RIVERS
    NarrowWater narrow = narrow_water(pixel);
    material.albedo *= mix(vec3(1.0), WETTED, narrow.damp);
#endif
    vec2 open = light_visibility(s.point);
#ifdef GROUND_COVER
    cover_ground(s, ground, normal, material, open);
#endif
#ifdef GROUND_CLUTTER
    stand_clutter(s, water.to_sun, ground, shown.rises, gradient, material, normal, open);
#endif
    vec3 beam = frame.sun_irradiance * open.x * air_to_space(s.place, frame.sun_direction);
    vec3 radiance = ground_light(s, material.albedo, normal, beam, water, open, ground.hidden_slope);
    vec4 sheen = shore_sheen(wet, s.point, s.view, s.zenith, normal, beam);
    radiance = radiance * (1.0 - sheen.a) + sheen.rgb;
#if defined(GROUND_RIVERS) && SHADE_EVERY < 4
    if (narrow.coverage > 0.0)
        radiance = mix(radiance, narrow_water_light(narrow, s.place, s.zenith, s.view, beam * water.sun),
            narrow.coverage);
#endif

    Air between = air_from_camera(s.place);
    return radiance * between.transmittance + between.in_scatter;
}

void main() {
    ivec2 first = tile_pixel();
    int turn = 0;
    do {
        ivec2 pixel = first;
        if (find_shown(pixel, turn, SURFACE_TERRAIN)) {
            v_ndc = ndc_of_pixel(vec2(pixel) + 0.5);
            imageStore(u_radiance, pixel, vec4(ground_radiance(pixel) * frame.hdr_per_radiance, 1.0));
        }
    } while (++turn < SHADE_TURNS);
}
