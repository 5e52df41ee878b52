// Light of the projected grid's paper mode: the illumination model of Phong with a normal map projected along three
// axes. Colours follow height, latitude and slope; the paper doesn't print any.
#include "generated/bindings.glsl"
#include "common/constants.glsl"
#include "common/camera.glsl"
#include "common/octahedral.glsl"
#include "common/surface_tiles.glsl"
#include "generated/paper_grid.glsl"
#include "generated/terrain_albedos.glsl"
#include "contract/air.glsl"
#include "contract/sky.glsl"
#include "contract/skylight.glsl"
#include "contract/sun_visibility.glsl"

layout(binding = GROUND_TILE_UNIT) uniform sampler2D u_normal_map;   // slopes along x and y of a tile

vec2 v_ndc;   // of the pixel at hand

const float STARLIGHT = 1.5e-8;    // as in terrain/shade.comp
const float SHINE = 0.008, SHININESS = 12.0;   // share of light in the highlight, exponent of its cosine

vec3 ground_color(vec3 zenith, float height, float slope) {
    float above_sea = height - (planet.has_sea ? planet.sea_level_m : planet.lowest_m);
    float sine2 = zenith.z * zenith.z;
    float rise_m = terrain_material_block.snow_line_rise_m * sine2 * (0.4 + 0.6 * sqrt(sine2));
    float line = terrain_material_block.snow_line_m + rise_m;
    float plants = terrain_material_block.plants;
    float warm = clamp((line - height) * terrain_material_block.warmth_per_m, 0.0, 1.0);
    vec3 color = mix(TUNDRA_ALBEDO, GRASS_ALBEDO, smoothstep(0.05, 0.3, warm));
    float dry = 1.0 - plants * (1.0 - 0.85 * smoothstep(0.16, 0.03, abs(sine2 - 0.17)));
    color = mix(color, DRY_ALBEDO, dry);
    color = mix(color, ROCK_ALBEDO, smoothstep(0.7, 1.3, slope / terrain_material_block.rock_slope));
    color = mix(SAND_ALBEDO, color,
        smoothstep(0.5, 2.0, above_sea * terrain_material_block.per_beach_height));
    float snow = smoothstep(-150.0, 150.0, height - line)
        * smoothstep(1.4, 0.7, slope / terrain_material_block.snow_slope);
    return mix(color, SNOW_ALBEDO, snow);
}

void main() {
    ivec2 pixel = tile_pixel();
    if (any(greaterThanEqual(pixel, textureSize(u_surface, 0))) || texelFetch(u_surface, pixel, 0).r != SURFACE_TERRAIN)
        return;
    v_ndc = ndc_of_pixel(vec2(pixel) + 0.5);
    vec3 point = position_from_depth(v_ndc, texelFetch(u_depth, pixel, 0).r);
    float height;
    vec3 D = foot_offset_of(point, height);
    vec3 zenith = up_at(point);
    float distance_m = length(point);
    vec3 view = -point / distance_m;
    vec3 normal = oct_decode(texelFetch(u_normal, pixel, 0).rg);
    // Far away a triangle's chord cuts kilometres below the sphere: heights come from the vertices.
    vec4 attributes = texelFetch(u_attributes, pixel, 0);
    float coded = mix(planet.lowest_m, planet.highest_m, attributes.z);
    height = mix(height, coded, smoothstep(0.02, 0.1, distance_m / planet.radius_m));

    // Three projections of one map, weighted by the normal; the map fades by its own mip levels.
    vec3 place = paper_grid.tile_place + D * paper_grid.tiles_per_m;
    vec3 weights = normal * normal;
    weights *= weights;
    weights /= weights.x + weights.y + weights.z;
    float texels = float(textureSize(u_normal_map, 0).x);
    float footprint = distance_m * frame.pixel_rad * inversesqrt(clamp(dot(normal, view), 0.03, 1.0));
    float level = log2(max(footprint * paper_grid.tiles_per_m * texels, 1.0));
    vec2 x = textureLod(u_normal_map, place.yz, level).rg, y = textureLod(u_normal_map, place.zx, level).rg;
    vec2 z = textureLod(u_normal_map, place.xy, level).rg;
    vec3 slope = weights.x * vec3(0.0, x) + weights.y * vec3(y.y, 0.0, y.x) + weights.z * vec3(z, 0.0);
    float steep = length(zenith - normal / max(dot(normal, zenith), 0.05));
    normal = normalize(normal - slope + normal * dot(normal, slope));

    vec3 albedo = ground_color(zenith, height, steep);
    vec3 sun = frame.sun_direction;
    vec3 sunlight = frame.sun_irradiance * sun_visibility(point) * air_to_space(point, sun);
    vec3 ambient = skylight(point, normal) + frame.sun_irradiance * STARLIGHT;
    float diffuse = max(dot(normal, sun), 0.0);
    float shine = diffuse > 0.0 ? pow(max(dot(reflect(-sun, normal), view), 0.0), SHININESS) : 0.0;
    vec3 radiance = albedo * (ambient + sunlight * diffuse) / PI
        + sunlight * (SHINE * (SHININESS + 2.0) / (2.0 * PI) * shine);
    Air between = air_from_camera(point);
    radiance = radiance * between.transmittance + between.in_scatter;
    imageStore(u_radiance, pixel, vec4(radiance * frame.hdr_per_radiance, 1.0));
}
