// Heights, normals and attributes of tiles, into their slots: an invocation a vertex, tiles along x. Everything is a
// function of the vertex's integers, so tiles that share a vertex get the same height whenever and at whatever level
// they are made.
#define TILE_MAKE
#include "generated/bindings.glsl"
#include "generated/planet.glsl"
#include "common/octahedral.glsl"
#include "terrain/canonical_height.glsl"
#include "terrain/attributes.glsl"
#include "generated/tile_slots.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = TILE_REQUEST_BUFFER) readonly buffer RequestBuffer { TileRequest requests[]; };
layout(std430, binding = TILE_SLOT_BUFFER) writeonly buffer SlotBuffer { TileVertex slots[]; };
layout(std430, binding = TILE_TABLE_BUFFER) readonly buffer TableBuffer { vec2 tile_tables[]; };
uniform float u_steps_per_m;

#include "terrain/tiles/scheme.glsl"

void main() {
    TileRequest tile = requests[gl_WorkGroupID.x];
    int k = min(int(gl_WorkGroupID.y * 64u + gl_LocalInvocationID.x), TILE_VERTICES - 1);
    Pair3 up = tile_direction(tile, k);
    Pair height;
    TerrainPoint terrain = terrain_canonical(up, tile.spacing_m, height);
    float radius = planet.radius_m, height_m = terrain.dh;
    vec3 normal = normalize(up.high - terrain.gradient * (radius / (radius + height_m)));
    TileVertex vertex;
    vertex.height = height_fixed(height, u_steps_per_m);
    vertex.normal = oct_pack(normal);
    vertex.attributes = packUnorm4x8(terrain_attributes(terrain, height_m, tile.spacing_m));
    slots[tile.slot * uint(TILE_VERTICES) + uint(k)] = vertex;
}
