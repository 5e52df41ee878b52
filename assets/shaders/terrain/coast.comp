// The line between land and water, pixel by pixel: the meshes meet along straight edges some pixels long, the height function
// knows better. Pixels change sides in the G-buffer before anything is shaded.
#include "common/camera.glsl"
#include "common/octahedral.glsl"
#include "common/sea_depth.glsl"
#include "common/surfaces.glsl"
#include "terrain/height.glsl"
#include "terrain/attributes.glsl"
#include "contract/vertex_spacing.glsl"
#include "contract/waterline.glsl"

layout(local_size_x = 16, local_size_y = 8) in;
layout(std430, binding = 7) readonly buffer TileBuffer {
    uint tile_groups[4];
    uint tiles[];
};
layout(binding = 0) uniform sampler2D u_depth;
layout(binding = 2) uniform sampler2D u_attributes;
layout(binding = 3) uniform usampler2D u_surface;
layout(binding = 0) writeonly uniform image2D u_normal_out;
layout(binding = 1) writeonly uniform image2D u_attributes_out;
layout(binding = 2) writeonly uniform uimage2D u_surface_out;

// The height function is asked at each pixel, or at every second or fourth (terrain.coast_px) and interpolated between.
#ifndef COAST_STEP
#define COAST_STEP 1
#endif
#if COAST_STEP == 1
const int COLUMNS = 16, ROWS = 8, CORNERS = 1;
#else
const int COLUMNS = 16 / COAST_STEP + 1, ROWS = 8 / COAST_STEP + 1, CORNERS = 4;
#endif
shared vec4 s_ground[COLUMNS * ROWS];     // xyz: gradient; w: height above the sea
shared vec4 s_attributes[COLUMNS * ROWS]; // w: depth, 0 where there is nothing
const ivec2 TILE = ivec2(16, 8);
// How far depth may be from linear on screen, relative, before pixels beside one another count as parts of different ground.
const float RIDGE = 0.005;

void sample_ground(int index, ivec2 first) {
    ivec2 pixel = min(first + COAST_STEP * ivec2(index % COLUMNS, index / COLUMNS), textureSize(u_surface, 0) - 1);
    float depth = texelFetch(u_depth, pixel, 0).r;
    vec3 point = position_from_depth(ndc_of_pixel(vec2(pixel) + 0.5), max(depth, 1e-30));
    float drawn;
    vec3 D = foot_offset_of(point, drawn);
    float spacing = vertex_spacing(D, texelFetch(u_attributes, pixel, 0).w);
    // Heights have all layers down to an eighth of this: what is shorter than 1.5 steps would only make dots of the samples.
    TerrainPoint terrain = terrain_point(D, 12.0 * float(COAST_STEP) * length(point) * frame.clock.w);
    float height = frame.anchor_up.w + terrain.dh;
    bool there = depth > 0.0;   // beside the limb there is nothing, and nothing finite comes of it
    s_ground[index] = there ? vec4(terrain.gradient, height - planet.sea.x) : vec4(0.0);
    s_attributes[index] = there ? vec4(terrain_attributes(terrain, height, spacing).xyz, depth) : vec4(0.0);
}

void main() {
    uint tile = tiles[gl_WorkGroupID.x];
    ivec2 first = ivec2(tile & 0xffffu, tile >> 16) * TILE;
    if (gl_LocalInvocationIndex < uint(COLUMNS * ROWS)) sample_ground(int(gl_LocalInvocationIndex), first);
    barrier();

    ivec2 here = ivec2(gl_LocalInvocationID.xy), pixel = first + here;
    if (any(greaterThanEqual(pixel, textureSize(u_surface, 0)))) return;
    uint surface = texelFetch(u_surface, pixel, 0).r;
    if (surface != SURFACE_TERRAIN && surface != SURFACE_SEA) return;
    // Seen from under water the bed is below the sea, and still in front of it.
    if (lens_in_water(ndc_of_pixel(vec2(pixel) + 0.5))) return;
    float own = texelFetch(u_depth, pixel, 0).r, total = 0.0;
    vec4 ground = vec4(0.0), attributes = vec4(0.0);
    vec2 part = vec2(here % COAST_STEP) / float(COAST_STEP);
    for (int k = 0; k < CORNERS; ++k) {
        ivec2 corner = ivec2(k & 1, k >> 1);
        vec2 near = mix(1.0 - part, part, vec2(corner));
        int index = (here.y / COAST_STEP + corner.y) * COLUMNS + here.x / COAST_STEP + corner.x;
        float weight = s_attributes[index].w > 0.0 ? near.x * near.y : 0.0;
        ground += weight * s_ground[index];
        attributes += weight * s_attributes[index];
        total += weight;
    }
    if (total < 1e-3) return;
    ground /= total;
    attributes /= total;
    // Along a plane depth is linear on screen. Where it is not, the corners lie before and behind a ridge, and what they see is
    // not the ground of this pixel: what was drawn as land stays land.
    if (surface == SURFACE_TERRAIN && abs(attributes.w - own) > RIDGE * own) return;
    attributes.w = 0.0;

    vec3 point = position_from_depth(ndc_of_pixel(vec2(pixel) + 0.5), own);
    float drawn;
    vec3 D = foot_offset_of(point, drawn);
    float code = texelFetch(u_attributes, pixel, 0).w;
    float spacing = vertex_spacing(D, code), sagitta = spacing * spacing / (8.0 * planet.radii.x);
    // Ground that was drawn well above the water stays: the meshes are wrong by a fraction of their spacing at most.
    if (surface == SURFACE_TERRAIN && drawn - planet.sea.x > 0.5 * spacing + sagitta + 2.0) return;
    vec3 zenith = up_at(point);
    float depth = max(-ground.w, 0.0);
    if (ground.w < 0.0) {
        if (surface == SURFACE_TERRAIN) {
            imageStore(u_normal_out, pixel, vec4(oct_encode(zenith), 0.0, 0.0));
            imageStore(u_surface_out, pixel, uvec4(SURFACE_SEA));
        }
        imageStore(u_attributes_out, pixel, vec4(sea_depth_encode(depth / (depth + 16.0)), 0.0, code));
    } else if (surface == SURFACE_SEA) {
        float to_sphere = planet.radii.x / (planet.radii.x + planet.sea.x + ground.w);
        imageStore(u_normal_out, pixel, vec4(oct_encode(normalize(zenith - ground.xyz * to_sphere)), 0.0, 0.0));
        imageStore(u_attributes_out, pixel, vec4(attributes.xyz, code));
        imageStore(u_surface_out, pixel, uvec4(SURFACE_TERRAIN));
    }
}
