// The triangles of all visible patches: an invocation a quad of the finest first. Along an edge with fewer segments
// than the patch, vertices are rounded down to those that both sides have; some triangles are flat there.
#include "generated/bindings.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = PATCH_BUFFER) readonly buffer PatchBuffer { uvec2 patches[]; };
layout(std430, binding = VISIBLE_BUFFER) readonly buffer VisibleBuffer { uint visible[]; };
layout(std430, binding = COUNT_BUFFER) readonly buffer CountBuffer { uint counts[]; };
layout(std430, binding = INDEX_BUFFER) writeonly buffer IndexBuffer { uint indices[]; };
uniform int u_patches[PAPER_LEVELS];

uint paper_vertex(uvec2 patch_word, int level, ivec2 ab) {
    int side = 1 << level;
    int along_j = ab.x == 0 ? paper_edge_level(patch_word.x, 0) : ab.x == side ? paper_edge_level(patch_word.x, 1)
        : level;
    int along_i = ab.y == 0 ? paper_edge_level(patch_word.x, 2) : ab.y == side ? paper_edge_level(patch_word.x, 3)
        : level;
    ab = ivec2((ab.x >> (level - along_i)) << (level - along_i), (ab.y >> (level - along_j)) << (level - along_j));
    return patch_word.y + uint(ab.y * (side + 1) + ab.x);
}

void main() {
    uint index = gl_GlobalInvocationID.x, first_quad = 0u, quad = 0u, slot = 0u;
    int first_patch = 0, level = -1;
    for (int k = PAPER_LEVELS - 1; k >= 0; --k) {
        uint end = first_quad + (counts[k] << (2 * k));
        bool here = index >= first_quad && index < end;
        uint within = index - first_quad;
        slot = here ? uint(first_patch) + (within >> (2 * k)) : slot;
        quad = here ? within & ((1u << (2 * k)) - 1u) : quad;
        level = here ? k : level;
        first_quad = end;
        first_patch += u_patches[k];
    }
    if (level < 0) return;
    uvec2 patch_word = patches[visible[slot]];
    ivec2 ab = ivec2(int(quad) & ((1 << level) - 1), int(quad) >> level);
    uint a = paper_vertex(patch_word, level, ab), b = paper_vertex(patch_word, level, ab + ivec2(1, 0));
    uint c = paper_vertex(patch_word, level, ab + ivec2(0, 1)), d = paper_vertex(patch_word, level, ab + 1);
    uint at = 6u * index;
    indices[at] = a;
    indices[at + 1u] = b;
    indices[at + 2u] = d;
    indices[at + 3u] = a;
    indices[at + 4u] = d;
    indices[at + 5u] = c;
}
