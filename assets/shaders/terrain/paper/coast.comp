// The line between land and water of the projected grid's paper mode, pixel by pixel, as terrain/coast_ask.comp has it
// for the others: not the paper's, but without it a comparison would be one of coasts.
#include "generated/bindings.glsl"
#include "common/camera.glsl"
#include "common/octahedral.glsl"
#include "common/sea_depth.glsl"
#include "common/surfaces.glsl"
#include "common/spacing_code.glsl"
#include "terrain/paper/ground.glsl"
#include "contract/waterline.glsl"

layout(local_size_x = TILE_WIDTH, local_size_y = TILE_HEIGHT) in;
layout(std430, binding = TILE_BUFFER) readonly buffer TileBuffer {
    uint tile_groups[4];
    uint tiles[];
};
layout(binding = DEPTH_UNIT) uniform sampler2D u_depth;
layout(binding = ATTRIBUTES_UNIT) uniform sampler2D u_attributes;
layout(binding = SURFACE_UNIT) uniform usampler2D u_surface;
layout(binding = COAST_NORMAL_IMAGE) writeonly uniform image2D u_normal_out;
layout(binding = COAST_ATTRIBUTES_IMAGE) writeonly uniform image2D u_attributes_out;
layout(binding = COAST_SURFACE_IMAGE) writeonly uniform uimage2D u_surface_out;

void main() {
    uint tile = tiles[gl_WorkGroupID.x];
    ivec2 pixel = ivec2(tile & 0xffffu, tile >> 16) * TILE_PX + ivec2(gl_LocalInvocationID.xy);
    if (any(greaterThanEqual(pixel, textureSize(u_surface, 0)))) return;
    uint surface = texelFetch(u_surface, pixel, 0).r;
    if (surface != SURFACE_TERRAIN && surface != SURFACE_SEA) return;
    if (lens_in_water(ndc_of_pixel(vec2(pixel) + 0.5))) return;   // a diver's bed is below the sea and in front of it
    vec3 point = position_from_depth(ndc_of_pixel(vec2(pixel) + 0.5), texelFetch(u_depth, pixel, 0).r);
    float drawn;
    vec3 D = foot_offset_of(point, drawn), zenith = up_at(point);
    float code = texelFetch(u_attributes, pixel, 0).w, spacing = spacing_decode(code);
    float sagitta = spacing * spacing / (8.0 * planet.radius_m);
    // Ground that was drawn well above the water stays: the meshes are wrong by a fraction of their spacing at most.
    if (surface == SURFACE_TERRAIN && drawn - planet.sea_level_m > 0.5 * spacing + sagitta + 2.0) return;
    // What is narrower than a pixel would make lone pixels of land and water, each by chance.
    float footprint = length(point) * frame.pixel_rad;
    float dh = paper_seen_dh(D, footprint), height = frame.anchor_height_m + dh, above = height - planet.sea_level_m;
    if (above < 0.0) {
        if (surface == SURFACE_TERRAIN) {
            imageStore(u_normal_out, pixel, vec4(oct_encode(zenith), 0.0, 0.0));
            imageStore(u_surface_out, pixel, uvec4(SURFACE_SEA));
        }
        imageStore(u_attributes_out, pixel, vec4(sea_depth_encode(above / (above - 16.0)), 0.0, code));
    } else if (surface == SURFACE_SEA) {
        vec3 helper = abs(zenith.x) < 0.6 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0);
        vec3 along = normalize(cross(zenith, helper)), across = cross(zenith, along);
        vec3 fall = zenith * (spacing * spacing / (2.0 * planet.radius_m));
        vec3 gradient = along * (paper_seen_dh(D + spacing * along - fall, footprint) - dh)
            + across * (paper_seen_dh(D + spacing * across - fall, footprint) - dh);
        float coded = (height - planet.lowest_m) / max(planet.highest_m - planet.lowest_m, 1.0);
        imageStore(u_normal_out, pixel, vec4(oct_encode(normalize(zenith - gradient / spacing)), 0.0, 0.0));
        imageStore(u_attributes_out, pixel, vec4(0.0, 0.0, clamp(coded, 1.0 / 255.0, 1.0), code));
        imageStore(u_surface_out, pixel, uvec4(SURFACE_TERRAIN));
    }
}
