// Lowest and highest vertex of each tile that was just made, and its geometric error: how far the ground lies from the
// middles of some of its triangles' edges, up or down. A workgroup a tile.
#define TILE_MAKE
#include "generated/bindings.glsl"
#include "generated/planet.glsl"
#include "terrain/canonical_height.glsl"
#include "generated/tile_slots.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = TILE_REQUEST_BUFFER) readonly buffer RequestBuffer { TileRequest requests[]; };
layout(std430, binding = TILE_SLOT_BUFFER) readonly buffer SlotBuffer { TileVertex slots[]; };
layout(std430, binding = 1) writeonly buffer FactsBuffer { TileFacts facts[]; };
layout(std430, binding = TILE_TABLE_BUFFER) readonly buffer TableBuffer { vec2 tile_tables[]; };
uniform float u_steps_per_m;

#include "terrain/tiles/scheme.glsl"

shared ivec2 s_range[64];
shared float s_error[64];

void main() {
    TileRequest tile = requests[gl_WorkGroupID.x];
    uint lane = gl_LocalInvocationID.x, first = tile.slot * uint(TILE_VERTICES);
    ivec2 range = ivec2(0x7fffffff, -0x7fffffff);
    for (int k = int(lane); k < TILE_VERTICES; k += 64) {
        int height = slots[first + uint(k)].height;
        range = ivec2(min(range.x, height), max(range.y, height));
    }
    float error = 0.0;
    for (int n = int(lane); n < TILE_SAMPLES; n += 64) {
        int a, b;
        tile_sample(n, a, b);
        Pair3 at = tile_direction(tile, a), to = tile_direction(tile, b);
        int lower = slots[first + uint(a)].height, higher = slots[first + uint(b)].height;
        // Heights of both over the radius; the middle lies below their mean by the sagitta. Without cancellation.
        vec2 over = vec2(lower, higher) / u_steps_per_m / planet.radius_m;
        vec3 across = pair_sub(at, to).high;
        float mean = 1.0 + 0.5 * (over.x + over.y), bent = 0.25 * (1.0 + over.x) * (1.0 + over.y) * dot(across, across);
        float sagitta_m = planet.radius_m * bent / (mean + sqrt(mean * mean - bent));
        Pair3 raised = pair_add(pair_mul(at, vec3(over.x)), pair_mul(to, vec3(over.y)));
        Pair height;
        terrain_canonical(pair_unit(pair_add(pair_add(at, to), raised)), tile.spacing_m, height);
        int above = height_fixed(height, u_steps_per_m);
        error = max(error, abs(0.5 * (float(above - lower) + float(above - higher)) / u_steps_per_m + sagitta_m));
    }
    s_range[lane] = range;
    s_error[lane] = error;
    for (uint count = 32u; count > 0u; count >>= 1) {
        barrier();
        if (lane < count) {
            ivec2 other = s_range[lane + count];
            s_range[lane] = ivec2(min(s_range[lane].x, other.x), max(s_range[lane].y, other.y));
            s_error[lane] = max(s_error[lane], s_error[lane + count]);
        }
    }
    if (lane == 0u) facts[gl_WorkGroupID.x] = TileFacts(s_range[0].x, s_range[0].y, s_error[0]);
}
