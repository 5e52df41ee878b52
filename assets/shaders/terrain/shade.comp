// Materials and light of the ground, once per pixel: the vertices' normal, continued by the layers below their spacing.
// Far away, where a triangle's chord cuts kilometres below the sphere, heights come from the vertices.
//
//   GROUND_CLUTTER   ground so near that things that stand on it show
//   GROUND_DRY       no pixel has water over it, or is wet from it (terrain/list_wet.comp says where)
#include "common/camera.glsl"
#include "common/texel.glsl"
#include "common/octahedral.glsl"
#include "common/surface_tiles.glsl"
#include "terrain/height.glsl"
#include "terrain/attributes.glsl"
#include "terrain/material.glsl"
#ifdef GROUND_CLUTTER
#include "terrain/clutter.glsl"
#include "terrain/ripples.glsl"
#endif
#include "terrain/color_map.glsl"
#include "contract/air.glsl"
#include "contract/sky.glsl"
#include "contract/skylight.glsl"
#include "contract/sun_visibility.glsl"
#include "contract/vertex_spacing.glsl"
#ifdef GROUND_DRY
#include "common/water.glsl"
#else
#include "contract/water.glsl"
#endif

#ifndef GROUND_BLUR
#define GROUND_BLUR 0.5
#endif

vec2 v_ndc;   // of the pixel at hand

const float PI = 3.14159265358979;
const float STARLIGHT = 1.5e-8;   // of the sun's irradiance: 2e-3 lx of stars and airglow on a moonless night

// Reflected radiance per irradiance at normal incidence and albedo. Lambert's law, or for dust without air McEwen's
// 1991 mixture of it with Lommel and Seeliger's law, which makes the full disc flat; L falls with the phase angle (a
// fit in sin(phase / 2) to McEwen 1996, who gives a polynomial for the moon).
float reflected(float n_l, float n_v, vec3 view, vec3 sun) {
    float half_sine = sqrt(max(0.5 - 0.5 * dot(view, sun), 0.0));
    float share = terrain_material_block.look.y * max(1.0 - 1.15 * half_sine, 0.0);
    float seeliger = 2.0 * n_l / max(n_l + max(n_v, 0.0), 1e-3);
    return mix(n_l, seeliger, share) / PI;
}

#ifdef GROUND_CLUTTER
// A direction, as seen from the ground at hand if that was level: what rises along the ground is taken away.
vec3 levelled(vec3 direction, vec3 normal, vec3 zenith) {
    float up = dot(direction, zenith), rises = max(dot(direction, normal), 0.06);
    return normalize(direction + (rises - up) * zenith);
}

// Albedo of what stands on the ground: stones of both colours of rock, plants of those around, bushes of forest.
vec3 clutter_albedo(GroundClutter clutter, vec3 plant) {
    vec3 stone = mix(ROCK_ALBEDO, STRATA_ALBEDO, 0.3 + 0.3 * clutter.tint) * (1.0 + 0.35 * clutter.tint);
    vec3 leaves = mix(plant * (1.15 + 0.3 * clutter.tint), FOREST_ALBEDO * (1.5 + 0.5 * clutter.tint), clutter.bush);
    return mix(stone, leaves * clutter.light, clutter.plant);
}
#endif

#ifdef TERRAIN_COLORED
// The map's colour, broken up by the materials' noise, rock and freshly dug ground; near the eye half of the materials'
// own.
vec3 colored(Material material, Ground ground, vec3 zenith) {
    vec3 color = terrain_color(zenith, terrain_table.map.zw, ground.footprint_m / planet.radii.x);
    float variation = terrain_material_block.look.x;
    color *= 1.0 + variation * (0.12 * ground.fine + 0.08 * ground.broad);
    float rock = dot(ROCK_ALBEDO, vec3(1.0)), level = max(dot(DRY_ALBEDO, vec3(1.0)), 1e-3);
    color *= mix(1.0, clamp(rock / level, 0.6, 1.6), 0.7 * material.rock);
    color *= 1.0 + 0.35 * clamp((TERRAIN_COLORED_MOISTURE - ground.moisture) / TERRAIN_DUG_DRY, 0.0, 1.5);
    color = mix(color, material.albedo, 0.5 * ramp(30.0, 0.5, ground.footprint_m));
    return clamp(mix(material.albedo, color, terrain_table.map_scale.z), 0.0, 1.0);
}
#endif

vec3 ground_radiance(ivec2 pixel) {
    vec3 point = position_from_depth(v_ndc, texel_at(u_depth, pixel).r);
    float height;
    vec3 D = foot_offset_of(point, height);
    vec3 zenith = up_at(point);
    float distance_m = length(point);
    vec3 view = -point / distance_m;
    vec3 coarse = oct_decode(texel_at(u_normal, pixel).rg);
    vec4 attributes = texel_at(u_attributes, pixel);
    float roughness = terrain_roughness(attributes), moisture = attributes.y;

    // What a pixel covers on the ground: wider along the view at flat angles. GROUND_BLUR 1/2 is the geometric mean;
    // less keeps detail sharp across the view and leaves it to the samples of anti-aliasing to average along it.
    float across = distance_m * frame.clock.w * (SHADE_EVERY == 4 ? 2.0 : 1.0);
    float footprint = 0.85 * across * pow(clamp(dot(coarse, view), 0.03, 1.0), -GROUND_BLUR);
    float spacing = vertex_spacing(D, attributes.w);
    float to_sphere = planet.radii.x / (planet.radii.x + height);
    vec3 gradient = zenith - coarse / max(dot(coarse, zenith), 0.05), rises = gradient;

    float sagitta = spacing * spacing / (8.0 * planet.radii.x);
    float coded = mix(planet.radii.z, planet.radii.y, attributes.z);
    float drawn = height;
    height = mix(height, coded, attributes.z > 0.0 ? smoothstep(2.0, 20.0, sagitta) : 0.0);
    // in the air: between their corners far triangles lie deep under the ground
    vec3 place = point + zenith * (height - drawn);

    GroundDetail detail = ground_detail(D, roughness, spacing, footprint);
    vec3 relief = roughness * to_sphere * detail.gradient;
    gradient += relief - zenith * dot(zenith, relief);
    vec4 dug = terrain_crater_detail(D, spacing, footprint);
    gradient += to_sphere * (dug.xyz + terrain_mapped_detail(D, spacing, footprint));
    moisture = max(moisture - TERRAIN_DUG_DRY * dug.w, 0.0);
    Ground ground = ground_at(detail, zenith, height, gradient, roughness, moisture, footprint);
    Material material = terrain_material(ground);
#ifdef TERRAIN_COLORED
    if (terrain_table.map.z > 0)
        material.albedo = colored(material, ground, zenith);
#endif
    vec3 bumps = material.grain * detail.grain;
#ifdef GROUND_CLUTTER
    // No wind without air.
    vec4 rippled = ripples(D, material.ripples.step, material.ripples.bend, footprint)
        * (material.ripples.share * (1.0 - terrain_material_block.look.y));
    bumps += material.ripples.slope * terrain_material_block.look.w * rippled.xyz;
    material.albedo *= 1.0 + material.ripples.tint * rippled.w;
#endif
    gradient += bumps - zenith * dot(zenith, bumps);
    vec3 normal = normalize(zenith - gradient);

    // Water over the ground, and ground that is wet from it.
    float rise = footprint * max(length(gradient), 0.02);
    Shore wet = shore(D, height, rise, footprint);
    WaterLight water = water_light(D, zenith, height, footprint);
    material.albedo *= mix(vec3(1.0), vec3(0.52, 0.5, 0.47), wet.damp);
    material.albedo = mix(material.albedo, wet.foam_albedo, wet.foam);

    vec3 sun = water.to_sun;
    vec2 open = light_visibility(point);
#ifdef GROUND_CLUTTER
    GroundClutter clutter = ground_clutter(D, zenith, levelled(view, coarse, zenith), levelled(sun, coarse, zenith),
        across, material.stony, material.leafy * vec4(1.0, 1.0, 1.0, ramp(10.0, 25.0, distance_m * dot(view, zenith))),
        ground.above_sea_m, rises);
    material.albedo = mix(material.albedo, clutter_albedo(clutter, material.plant), clutter.cover);
    normal = normalize(normal * (1.0 - clutter.cover) + clutter.normal - gradient * dot(clutter.normal, zenith));
    open *= mix(vec2(clutter.sun, clutter.sky), vec2(1.0), clutter.cover);
#endif

    // Mean over the slopes that a pixel hides: max(x, 0) turns into a soft bend as wide as they spread.
    float mu = dot(normal, sun), soft = 0.5 * ground.hidden_slope;
    float n_l = 0.5 * (mu + sqrt(mu * mu + soft * soft))
        - 0.5 * soft * clamp(1.0 - mu / max(soft, 1e-4), 0.0, 1.0) * 0.5;
    vec3 beam = frame.sun_irradiance.rgb * open.x * air_to_space(place, frame.sun_direction.xyz),
        sunlight = beam * water.sun;
    // Light that lit neighbouring ground throws back: without it the airless dark sides would be pure black.
    float sun_height = max(dot(zenith, sun), 0.0);
    vec3 bounce = material.albedo * sunlight * sun_height * (0.5 - 0.5 * dot(normal, zenith)) * 0.6;
    vec3 irradiance = (skylight(place, normal) * water.sky + bounce + frame.sun_irradiance.rgb * STARLIGHT) * open.y;
    vec3 radiance = material.albedo * (sunlight * reflected(max(n_l, 0.0), dot(normal, view), view, sun)
        + irradiance / PI);
    vec4 sheen = shore_sheen(wet, point, view, zenith, normal, beam);
    radiance = radiance * (1.0 - sheen.a) + sheen.rgb;

    Air between = air_from_camera(place);
    return radiance * between.transmittance + between.in_scatter;
}

void main() {
    ivec2 first = tile_pixel();
    int turn = 0;
    do {
        ivec2 pixel = first;
        if (find_shown(pixel, turn, SURFACE_TERRAIN)) {
            v_ndc = ndc_of_pixel(vec2(pixel) + 0.5);
            imageStore(u_radiance, pixel, vec4(ground_radiance(pixel) * frame.scale.x, 1.0));
        }
    } while (++turn < SHADE_TURNS);
}
