// Feet of all vertices of the projected grid and the depth below them, on a snap of the proxy: an invocation a vertex.
// Patches are sorted by level, the finest first, so that a vertex finds its patch by a division.
#include "generated/bindings.glsl"
#include "ocean/paper/grid.glsl"
#include "ocean/paper/vertex.glsl"
#include "contract/surface_height.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = PATCH_BUFFER) readonly buffer PatchBuffer { uvec2 patches[]; };   // word, first vertex
layout(std430, binding = VERTEX_BUFFER) writeonly buffer VertexBuffer { CalmVertex vertices[]; };
uniform int u_count;
uniform int u_patches[PAPER_LEVELS];   // of each level

void main() {
    int index = int(gl_GlobalInvocationID.x);
    if (index >= u_count) return;
    int first_patch = 0, first_vertex = 0, patch_index = 0, local = 0, level = 0;
    for (int k = PAPER_LEVELS - 1; k >= 0; --k) {
        int side = (1 << k) + 1, size = side * side, end = first_vertex + u_patches[k] * size;
        bool here = index >= first_vertex && index < end;
        int within = index - first_vertex;
        patch_index = here ? first_patch + within / size : patch_index;
        local = here ? within % size : local;
        level = here ? k : level;
        first_patch += u_patches[k];
        first_vertex = end;
    }
    int side = (1 << level) + 1;
    ivec2 p = paper_patch_place(patches[patch_index].x)
        + (ivec2(local % side, local / side) << (PAPER_LEVELS - 1 - level));
    vec3 D = paper_foot(p);
    float spacing = paper_spacing(D);
    float depth = max(planet.sea_level_m - surface_height(D, spacing), 0.0);
    vertices[index] = CalmVertex(D.x, D.y, D.z, depth / (depth + 16.0));
}
