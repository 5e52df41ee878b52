// How many vertices each cell would like to skip: the most for which nearly all of its edges, as they lie displaced, keep to the
// wanted length as seen from the proxy. A workgroup a cell, after the vertices were made.
#include "common/cells.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = 1) readonly buffer VertexBuffer { CellVertex vertices[]; };
layout(std430, binding = 2) writeonly buffer WantedBuffer { uint wanted[]; };
uniform vec3 u_eye;         // the proxy, metres from the anchor
uniform float u_angle;      // the wanted length of an edge, radians
uniform int u_most;

shared uint s_long[2 * CELL_MOST];

vec3 vertex_position(uint first, int a, int b) {
    CellVertex vertex = vertices[first + uint(b * CELL_SIDE + a)];
    return vec3(vertex.x, vertex.y, vertex.z) - u_eye;
}

// Square of the angle under which an edge is seen, near enough for small ones.
float angle_squared(vec3 from, vec3 to) {
    vec3 edge = to - from;
    vec3 middle = 0.5 * (from + to);
    float distance2 = max(dot(middle, middle), 1e-12);
    vec3 across = edge - middle * (dot(edge, middle) / distance2);
    return dot(across, across) / distance2;
}

void main() {
    uint cell = gl_WorkGroupID.x, first = cell * uint(CELL_VERTICES);
    if (gl_LocalInvocationID.x < uint(2 * CELL_MOST)) s_long[gl_LocalInvocationID.x] = 0u;
    barrier();
    float limit = u_angle * u_angle;
    for (int skip = 1; skip <= u_most; ++skip) {
        int step = 1 << skip, count = CELL_QUADS / step;
        uint too_long_i = 0u, too_long_j = 0u;
        for (int k = int(gl_LocalInvocationID.x); k < count * (count + 1); k += 64) {
            int along = (k % count) * step, across = (k / count) * step;
            if (angle_squared(vertex_position(first, along, across), vertex_position(first, along + step, across)) > limit) ++too_long_i;
            if (angle_squared(vertex_position(first, across, along), vertex_position(first, across, along + step)) > limit) ++too_long_j;
        }
        atomicAdd(s_long[2 * skip - 2], too_long_i);
        atomicAdd(s_long[2 * skip - 1], too_long_j);
    }
    barrier();
    if (gl_LocalInvocationID.x == 0u) {
        uint skip_i = 0u, skip_j = 0u;
        for (int skip = 1; skip <= u_most; ++skip) {
            uint count = uint(CELL_QUADS >> skip), allowed = count * (count + 1u) / 32u;
            if (s_long[2 * skip - 2] <= allowed && skip_i == uint(skip - 1)) skip_i = uint(skip);
            if (s_long[2 * skip - 1] <= allowed && skip_j == uint(skip - 1)) skip_j = uint(skip);
        }
        wanted[2u * cell] = skip_i;
        wanted[2u * cell + 1u] = skip_j;
    }
}
