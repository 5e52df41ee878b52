#include "common/camera.glsl"
#include "common/cells.glsl"
#include "common/octahedral.glsl"

layout(std430, binding = 0) readonly buffer CellBuffer { Cell cells[]; };
layout(std430, binding = 1) readonly buffer VertexBuffer { CellVertex vertices[]; };
layout(std430, binding = 2) readonly buffer VisibleBuffer { uint visible[]; };

out vec3 v_normal;
out float v_shallow;   // depth / (depth + 16 m)
flat out int v_level;

void main() {
    uint cell_index = visible[gl_InstanceID];
    CellVertex vertex = vertices[cell_index * uint(CELL_VERTICES) + uint(cell_masked_vertex(cells[cell_index].edge_delta, gl_VertexID))];
    gl_Position = clip_position(vec3(vertex.x, vertex.y, vertex.z) - frame.camera_offset.xyz);
    v_normal = oct_decode(unpackSnorm2x16(vertex.normal));
    v_shallow = unpackUnorm2x16(vertex.attributes).x;
    v_level = cells[cell_index].level;
}
