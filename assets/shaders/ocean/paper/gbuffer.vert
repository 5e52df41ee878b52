#include "generated/bindings.glsl"
#include "common/camera.glsl"
#include "common/octahedral.glsl"
#include "ocean/paper/grid.glsl"
#include "ocean/paper/vertex.glsl"

layout(std430, binding = VERTEX_BUFFER) readonly buffer VertexBuffer { WavyVertex vertices[]; };

out vec3 v_normal;
out float v_shallow;
flat out float v_spacing;

void main() {
    WavyVertex vertex = vertices[gl_VertexID];
    vec3 seen = vec3(vertex.x, vertex.y, vertex.z) - frame.camera_offset_m;
    gl_Position = clip_position(seen);
    v_normal = oct_decode(unpackSnorm2x16(vertex.normal));
    v_shallow = vertex.shallow;
    v_spacing = paper_spacing(vec3(vertex.x, vertex.y, vertex.z));
}
