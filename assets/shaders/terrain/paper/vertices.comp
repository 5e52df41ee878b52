// The vertices of all patches of the projected grid, on a snap of the proxy: an invocation a vertex. Patches are sorted
// by level, the finest first, so that a vertex finds its patch by a division. Normals come from two neighbouring
// heights.
#include "generated/bindings.glsl"
#include "terrain/paper/vertex.glsl"
#include "common/octahedral.glsl"
#include "common/spacing_code.glsl"
#include "terrain/paper/ground.glsl"
#include "terrain/paper/grid.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = PATCH_BUFFER) readonly buffer PatchBuffer { uvec2 patches[]; };   // word, first vertex
layout(std430, binding = VERTEX_BUFFER) writeonly buffer VertexBuffer { PaperVertex vertices[]; };
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
    vec3 D = paper_foot(p), up = frame.anchor_up;
    float radius = planet.radius_m, spacing = paper_spacing(D);
    vec3 zenith = normalize(up + D / radius);
    // The grid's axes, carried along the great circle from its middle; only the antipode of that has none.
    vec3 middle = paper_grid.third_axis, between = middle + zenith, carry = between / max(dot(between, middle), 1e-6);
    vec3 along = paper_grid.first_axis - dot(zenith, paper_grid.first_axis) * carry;
    vec3 across = paper_grid.second_axis - dot(zenith, paper_grid.second_axis) * carry;
    vec3 fall = zenith * (spacing * spacing / (2.0 * radius));
    float seen, dh = paper_dh(D, spacing, 0.0, seen);
    float rise_along = paper_dh(D + spacing * along - fall) - dh;
    float rise_across = paper_dh(D + spacing * across - fall) - dh;
    float height = frame.anchor_height_m + dh, to_sphere = radius / (radius + height);
    vec3 normal = normalize(zenith - (along * rise_along + across * rise_across) * (to_sphere / spacing));
    vec3 position = paper_position(D, dh);
    // Colours follow it far away: those of chance values would be blots.
    float coded = (frame.anchor_height_m + seen - planet.lowest_m) / max(planet.highest_m - planet.lowest_m, 1.0);
    PaperVertex vertex;
    vertex.x = position.x;
    vertex.y = position.y;
    vertex.z = position.z;
    vertex.dh = dh;
    vertex.normal = packSnorm2x16(oct_encode(normal));
    vertex.attributes = packUnorm4x8(vec4(0.0, 0.0, clamp(coded, 1.0 / 255.0, 1.0), spacing_encode(spacing)));
    vertices[index] = vertex;
}
