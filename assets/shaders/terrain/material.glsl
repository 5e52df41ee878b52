// First ground materials: rock, grass, sand and snow by height, slope, latitude and moisture.
#include "generated/terrain_material_block.glsl"

struct Material {
    vec3 albedo;
};

Material terrain_material(vec3 D, vec3 zenith, float height, float slope, float roughness, float moisture, float footprint) {
    vec3 rock = terrain_material_block.rock.rgb, grass = terrain_material_block.grass.rgb;
    vec3 sand = terrain_material_block.sand.rgb, snow = terrain_material_block.snow.rgb;
    float polar = zenith.z * zenith.z;
    float snow_line = mix(terrain_material_block.snow_line.x, terrain_material_block.snow_line.y, polar);
    float above_sea = height - (planet.sea.y > 0.5 ? planet.sea.x : -1.0e9);

    vec3 flat_ground = mix(sand * 0.8, grass, smoothstep(0.25, 0.6, moisture));
    float rocky = smoothstep(0.6, 1.0, slope / max(terrain_material_block.limits.x, 1e-3));
    vec3 albedo = mix(flat_ground, rock, rocky);
    float snowy = smoothstep(-200.0, 200.0, height - snow_line) * (1.0 - 0.8 * smoothstep(0.8, 1.4, slope));
    albedo = mix(albedo, snow, snowy);
    float beach = 1.0 - smoothstep(0.5, 1.0, above_sea / max(terrain_material_block.limits.y, 1e-3));
    albedo = mix(albedo, sand, beach * (1.0 - rocky));
    return Material(albedo);
}
