#include "common/camera.glsl"
#include "common/cells.glsl"
#include "common/octahedral.glsl"

layout(std430, binding = 0) readonly buffer CellBuffer { Cell cells[]; };
layout(std430, binding = 1) readonly buffer VertexBuffer { CellVertex vertices[]; };
in uint in_cell;

out vec3 v_normal;
out float v_shallow;   // depth / (depth + 16 m)
flat out float v_spacing;

void main() {
    CellVertex vertex = vertices[in_cell * uint(CELL_VERTICES) + uint(cell_masked_vertex(cells[in_cell].edge_mask, gl_VertexID))];
    gl_Position = clip_position(vec3(vertex.x, vertex.y, vertex.z) - frame.camera_offset.xyz);
    v_normal = oct_decode(unpackSnorm2x16(vertex.normal));
    v_shallow = unpackUnorm2x16(vertex.attributes).x;
    v_spacing = cells[in_cell].spacing_m;
}
