#include "generated/bindings.glsl"
#include "generated/frame.glsl"
#ifdef TERRAIN_FADE
#include "terrain/fade/locate.glsl"
#else
#include "common/cells.glsl"
#endif
#include "common/octahedral.glsl"

layout(std430, binding = CELL_BUFFER) readonly buffer CellBuffer { Cell cells[]; };
layout(std430, binding = VERTEX_BUFFER) readonly buffer VertexBuffer { CellVertex vertices[]; };
in uint in_cell;
#ifdef TERRAIN_FADE
// After a snap: the surface moves from the old selection's to the new one's.
layout(std430, binding = FADE_START_BUFFER) readonly buffer StartBuffer { FadeStart starts[]; };
layout(std430, binding = FADE_BUFFER) readonly buffer FadeBuffer { FadeCell fade[]; };
uniform float u_fade;   // 0: the old surface, 1: the new one
#endif

out vec3 v_normal;
out vec4 v_attributes;
flat out int v_level;

void main() {
    uint index = in_cell * uint(CELL_VERTICES) + uint(cell_masked_vertex(cells[in_cell].edge_mask, gl_VertexID));
    CellVertex vertex = vertices[index];
    precise vec3 place = vec3(vertex.x, vertex.y, vertex.z);
    vec3 normal = oct_decode(unpackSnorm2x16(vertex.normal));
#ifdef TERRAIN_FADE
    if (fade[in_cell].changed != 0u) {
        FadeStart start = starts[index];
        place += (start.position_m - place) * (1.0 - u_fade);
        normal = normalize(mix(oct_decode(unpackSnorm2x16(start.normal)), normal, u_fade));
    }
#endif
    precise vec3 seen = place - frame.camera_offset_m;
    float z = dot(seen, frame.camera_forward);
    vec2 xy = vec2(dot(seen, frame.camera_right), dot(seen, frame.camera_up));
    gl_Position = vec4((xy - frame.projection_offset * z) / frame.projection_scale, frame.near_m, z);
    v_normal = normal;
    v_attributes = unpackUnorm4x8(vertex.attributes);
    v_level = cells[in_cell].level;
}
