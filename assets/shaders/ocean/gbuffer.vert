#include "generated/bindings.glsl"
#include "common/camera.glsl"
#include "common/cells.glsl"
#include "common/octahedral.glsl"
#include "ocean/displaced.glsl"

layout(std430, binding = CELL_BUFFER) readonly buffer CellBuffer { Cell cells[]; };
#ifdef SEA_MOVES
layout(std430, binding = VERTEX_BUFFER) readonly buffer VertexBuffer { SeaVertex vertices[]; };
out vec2 v_moved;
#else
layout(std430, binding = VERTEX_BUFFER) readonly buffer VertexBuffer { CellVertex vertices[]; };
#endif
in uint in_cell;

out vec3 v_normal;
out float v_shallow;   // depth / (depth + 16 m)
flat out float v_spacing;

void main() {
    uint index = in_cell * uint(CELL_VERTICES) + uint(cell_masked_vertex(cells[in_cell].edge_mask, gl_VertexID));
    vec3 position = vec3(vertices[index].x, vertices[index].y, vertices[index].z);
    gl_Position = clip_position(position - frame.camera_offset_m);
    v_normal = oct_decode(unpackSnorm2x16(vertices[index].normal));
    v_shallow = unpackUnorm2x16(vertices[index].attributes).x;
    v_spacing = cells[in_cell].spacing_m;
#ifdef SEA_MOVES
    v_moved = unpackSnorm2x16(vertices[index].moved);
#endif
}
