// Albedo of the printed ground, for programs. Its colours are no materials.
#define main light_ground
#include "terrain/paper/shade.comp"
#undef main
#include "generated/material_ids.glsl"

void main() {
    ivec2 pixel = tile_pixel();
    if (!shows(pixel, SURFACE_TERRAIN)) return;
    vec3 point = position_from_depth(ndc_of_pixel(vec2(pixel) + 0.5), texelFetch(u_depth, pixel, 0).r);
    float height, coded = mix(planet.lowest_m, planet.highest_m, texelFetch(u_attributes, pixel, 0).z);
    foot_offset_of(point, height);
    vec3 zenith = up_at(point), normal = oct_decode(texelFetch(u_normal, pixel, 0).rg);
    height = mix(height, coded, smoothstep(0.02, 0.1, length(point) / planet.radius_m));
    float steep = length(zenith - normal / max(dot(normal, zenith), 0.05));
    imageStore(u_radiance, pixel, vec4(ground_color(zenith, height, steep), float(MATERIAL_GROUND)));
}
