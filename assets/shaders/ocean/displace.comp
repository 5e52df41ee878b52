// Vertices of the visible cells, moved by the waves: each frame in which time passes. The calm sea's vertices and the depth below
// them are those of the last snap.
#include "generated/frame.glsl"
#include "generated/planet.glsl"
#include "common/cells.glsl"
#include "common/sea_depth.glsl"
#include "ocean/displaced.glsl"
#include "ocean/waves.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer VertexBuffer { CellVertex vertices[]; };
layout(std430, binding = 3) writeonly buffer DisplacedBuffer { SeaVertex displaced[]; };
layout(std430, binding = 4) readonly buffer ListBuffer { uint list[]; };

void main() {
    uint first = list[4u + gl_WorkGroupID.x] * uint(CELL_VERTICES);
    float level = planet.sea.x, to_foot = 1.0 / wave_north.w;
    for (uint k = gl_LocalInvocationID.x; k < uint(CELL_VERTICES); k += 64u) {
        CellVertex calm = vertices[first + k];
        vec3 position = vec3(calm.x, calm.y, calm.z);
        vec3 D = (position - frame.anchor_up.xyz * calm.dh) * to_foot;
        float shallow = unpackUnorm2x16(calm.attributes).x;
        // The distance of vertices that was asked for here: a function of the place alone, so that cells of different levels agree
        // along their edges.
        float spacing = max(wave_mesh.x, wave_eye.w * length(position - wave_eye.xyz));
        SeaPlace place = sea_place(D);
        vec3 moved = sea_moved(place, sea_depth_m(shallow), spacing);
        position += sea_vector(place, moved);
        SeaVertex vertex;
        vertex.x = position.x;
        vertex.y = position.y;
        vertex.z = position.z;
        vertex.moved = packSnorm2x16(moved.xy / max(wave_counts.z, 1e-6));
        vertex.normal = calm.normal;
        vertex.attributes = calm.attributes;
        displaced[first + k] = vertex;
    }
}
