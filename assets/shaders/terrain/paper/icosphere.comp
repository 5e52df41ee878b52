// The vertices of all patches of the icosphere as printed, once per camera: a workgroup a patch. Each patch vertex has
// its place in the flat triangle and a morph vector, which it follows by its distance from the camera; then it is
// pushed out to the sphere and up to the height there.
#include "generated/bindings.glsl"
#include "generated/frame.glsl"
#include "generated/planet.glsl"
#include "common/cells.glsl"
#include "common/octahedral.glsl"
#include "terrain/height.glsl"
#include "terrain/attributes.glsl"
#include "terrain/tiles/triangle.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = PATCH_BUFFER) readonly buffer PatchBuffer { TileName patches[]; };
layout(std430, binding = VERTEX_BUFFER) writeonly buffer VertexBuffer { CellVertex vertices[]; };
uniform float u_split[32];        // metres: distance at which a triangle of a level is split
uniform float u_spacing[32];      // metres: longest distance of vertices
uniform float u_morph_range;
uniform float u_ground;           // height of the sphere that distances are measured to

// 1 where the parent would be drawn, 0 from a part of the level's range on.
float morph_of(int level, float distance_m) {
    if (level == 0) return 0.0;
    float low = u_split[level - 1], high = u_split[level];
    return 1.0 - clamp((distance_m - low) / (high - low) / u_morph_range, 0.0, 1.0);
}

// To the neighbour that the parent has too.
ivec2 morph_vector(ivec2 pq) {
    ivec2 odd = pq & 1;
    return odd.y == 0 ? ivec2(-odd.x, 0) : odd.x == 0 ? ivec2(0, 1) : ivec2(1, -1);
}

void main() {
    TileName name = patches[gl_WorkGroupID.x];
    int root = name.root, level = name.level;
    float radius = planet.radius_m;
    for (int k = int(gl_LocalInvocationID.x); k < TILE_VERTICES; k += 64) {
        ivec2 pq = pf_triangle_place(k, TILE_SEGMENTS), bc = pf_triangle_lattice(name, pq);
        vec3 foot = triangle_foot_offset(root, bc);
        vec3 ground = foot * (1.0 + u_ground / radius) + frame.anchor_up * (u_ground - frame.anchor_height_m);
        float distance_m = length(ground - frame.camera_offset_m);
        ivec2 to = pf_triangle_lattice(name, pq + morph_vector(pq));
        vec3 D = triangle_foot_offset_between(root, bc, to, morph_of(level, distance_m));
        TerrainPoint terrain = terrain_point(D, u_spacing[level]);
        float height = frame.anchor_height_m + terrain.dh;
        precise vec3 position = D * (1.0 + height / radius) + frame.anchor_up * terrain.dh;
        vec3 zenith = normalize(frame.anchor_up + D / radius);
        vec3 normal = normalize(zenith - terrain.gradient * (radius / (radius + height)));
        CellVertex vertex;
        vertex.x = position.x;
        vertex.y = position.y;
        vertex.z = position.z;
        vertex.dh = terrain.dh;
        vertex.normal = packSnorm2x16(oct_encode(normal));
        vertex.attributes = packUnorm4x8(terrain_attributes(terrain, height, u_spacing[level]));
        vertices[gl_WorkGroupID.x * uint(TILE_VERTICES) + uint(k)] = vertex;
    }
}
