// The ground's albedo and material, for programs: what terrain/shade.comp lights, without any light.
#define main light_ground
#include "terrain/shade.comp"
#undef main
#include "generated/material_ids.glsl"
#include "generated/terrain_material_ids.glsl"

#ifdef GROUND_COVER
// Woods beyond single trees: leaves and what lies below them, in the shares that the eye sees of either. As
// cover_ground() of terrain/forest.glsl, where the sun decides as well.
float woods(Spot s, Ground ground, inout Material material) {
    float far = smoothstep(CANOPY_FROM.x, CANOPY_FROM.y, s.distance_m * (1.0 / float(GROUND_COVER))) * material.inland;
    float trees = trees_grown(ground, material);
    Stand stand = far > 0.0 && trees > 0.0 ? stand_at(s.D, ground.region, ground.footprint_m) : Stand(0.0, 0.0, 0.0);
    float conifer = ramp(0.62, 0.34, ground.mean_warmth + STAND_CONIFERS * stand.hue);
    float grown = ramp(0.10, 0.34, ground.mean_warmth);
    vec4 broadleaf = mix(vec4(cover_map.broadleaf, 1.0), s.zenith.z < 0.0 ? cover_map.south : cover_map.north,
        ramp(SEASONAL.x, SEASONAL.y, abs(s.zenith.z)));
    float area = cover_map.crowns * stand_crowns(stand) * grown * mix(broadleaf.a, CONIFERS_GROUND, conifer)
        * trees * (1.0 - stand.open) * clamp(0.8 + 0.5 * ground.mixed, 0.0, 1.5);
    float tall = mix(CROWNS_TALL.x, CROWNS_TALL.y, conifer), rise = clamp(dot(s.view, s.zenith), 0.1, 1.0);
    float seen = 1.0 - exp(-area * sqrt(1.0 + tall * tall * (1.0 / (rise * rise) - 1.0)));
    vec3 leaves = mix(broadleaf.rgb, cover_map.conifer, conifer) * (1.0 + stand.hue * HUE_TINT);
    float snow = snow_on_trees(ground.mean_warmth, s.zenith.z, conifer);
    leaves = mix(leaves, cover_map.snow.rgb, clamp(snow * dot(SNOW_SEEN, vec2(1.0, rise)), 0.0, 1.0))
        * (1.0 + stand_grain() * ground.grain);
    material.albedo = mix(material.albedo, leaves, far * seen);
    material.growth.trees = 0.0;
    return far * seen;
}
#endif

void main() {
    ivec2 pixel = tile_pixel();
    if (!shows(pixel, SURFACE_TERRAIN)) return;
    v_ndc = ndc_of_pixel(vec2(pixel) + 0.5);
    vec4 attributes = texel_at(u_attributes, pixel);
    Spot s = spot_at(pixel, attributes);
    Shown shown = ground_shown(s, attributes, pixel);
    Material material = shown.material;
    uint number = terrain_material_id(shown.ground);
    Shore wet;
    ground_water(s, shown.gradient, material, wet);
#ifdef GROUND_COVER
    if (woods(s, shown.ground, material) > 0.5) number = MATERIAL_LEAVES;
#endif
#ifdef GROUND_CLUTTER
    vec3 normal = s.zenith;
    vec2 open = vec2(1.0);
    stand_clutter(s, frame.sun_direction, shown.ground, shown.rises, shown.gradient, material, normal,
        open);
#endif
#ifdef GROUND_RIVERS
    NarrowWater narrow = narrow_water(pixel);
    material.albedo *= mix(vec3(1.0), WETTED, narrow.damp);
    material.albedo *= 1.0 - narrow.coverage;   // water throws little back
    if (narrow.coverage > 0.5) number = MATERIAL_FRESH_WATER;
#endif
    imageStore(u_radiance, pixel, vec4(clamp(material.albedo, 0.0, 1.0), float(number)));
}
