// The line between land and water from heights at every fourth pixel (terrain.coast_px), interpolated between: for weak
// machines. terrain/coast_ask.comp asks at each pixel or every second.
#include "terrain/coast_pixel.glsl"

layout(local_size_x = 16, local_size_y = 8) in;
layout(std430, binding = 7) readonly buffer TileBuffer {
    uint tile_groups[4];
    uint tiles[];
};
#ifndef COAST_STEP
#define COAST_STEP 4
#endif
const int COLUMNS = 16 / COAST_STEP + 1, ROWS = 8 / COAST_STEP + 1, CORNERS = 4;
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
    CoastPixel p = coast_pixel(pixel);
    if (!p.open) return;
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
    if (p.surface == SURFACE_TERRAIN && abs(attributes.w - own) > RIDGE * own) return;
    if (ground.w < 0.0) coast_to_sea(pixel, p, -ground.w);
    else if (p.surface == SURFACE_SEA) coast_to_land(pixel, p, ground.xyz, ground.w, attributes.xyz);
}
