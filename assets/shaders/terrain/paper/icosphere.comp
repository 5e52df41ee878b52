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
uniform vec2 u_morph[32];         // metres: distances at which vertices of a level begin to morph and are the parent's
uniform float u_spacing[32];      // metres: longest distance of vertices
uniform float u_ground;           // height of the sphere that distances are measured to

// 0 as the level has it, 1 as its parent does.
float morph_of(int level, float distance_m) {
    if (level == 0) return 0.0;
    vec2 range = u_morph[level];
    return clamp((distance_m - range.x) / (range.y - range.x), 0.0, 1.0);
}

// To a neighbour that the parent has too. Triangles beside each other twist the opposite way round: triangle_paper.py.
ivec2 morph_vector(TileName name, ivec2 pq) {
    ivec2 odd = pq & 1;
    ivec2 vector = odd.y == 0 ? ivec2(-odd.x, 0) : odd.x == 0 ? ivec2(0, 1) : ivec2(1, -1);
    return ((name.level + name.j) & 1) == 0 ? vector : -vector;
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
        ivec2 to = pf_triangle_lattice(name, pq + morph_vector(name, pq));
        float morph = morph_of(level, distance_m);
        vec3 D = triangle_foot_offset_between(root, bc, to, morph);
        // The parent's is twice as wide: heights of the two levels meet as their places do.
        float spacing = u_spacing[level] * (1.0 + morph);
        TerrainPoint terrain = terrain_point(D, spacing);
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
        vertex.attributes = packUnorm4x8(terrain_attributes(terrain, height, spacing));
        vertices[gl_WorkGroupID.x * uint(TILE_VERTICES) + uint(k)] = vertex;
    }
}
