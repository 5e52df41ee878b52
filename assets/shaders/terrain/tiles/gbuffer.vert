#include "generated/bindings.glsl"
#include "generated/frame.glsl"
#include "common/cells.glsl"
#include "common/octahedral.glsl"

layout(std430, binding = VERTEX_BUFFER) readonly buffer VertexBuffer { CellVertex vertices[]; };
in uint in_slot;

out vec3 v_normal;
out vec4 v_attributes;
flat out int v_level;
flat out uint v_slot;

void main() {
    CellVertex vertex = vertices[in_slot * uint(CELL_VERTICES) + uint(gl_VertexID)];
    precise vec3 seen = vec3(vertex.x, vertex.y, vertex.z) - frame.camera_offset_m;
    float z = dot(seen, frame.camera_forward);
    vec2 xy = vec2(dot(seen, frame.camera_right), dot(seen, frame.camera_up));
    gl_Position = vec4((xy - frame.projection_offset * z) / frame.projection_scale, frame.near_m, z);
    v_normal = oct_decode(unpackSnorm2x16(vertex.normal));
    v_attributes = unpackUnorm4x8(vertex.attributes);
    v_slot = in_slot;
    v_level = 31 - int(vertex.attributes >> 27);   // the spacing's code in octaves
}
