// How many vertices each cell would like to skip: the most for which nearly all of its edges, as they lie displaced,
// keep to the wanted length as seen from the proxy, and pass the vertices that they leave out at a small fraction of it
// (ridges across the view, the sphere's own curve at the limb). And which diagonals are the shorter ones as seen from
// the proxy: a cell seen askew is a parallelogram on screen, whose long diagonal is up to twice its sides. A workgroup
// a cell, after the vertices were made.
#include "generated/bindings.glsl"
#include "common/cells.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = CELL_BUFFER) buffer CellBuffer { Cell cells[]; };
layout(std430, binding = VERTEX_BUFFER) readonly buffer VertexBuffer { CellVertex vertices[]; };
layout(std430, binding = WANTED_BUFFER) writeonly buffer WantedBuffer { uint wanted[]; };
uniform vec3 u_eye;         // the proxy, metres from the anchor
uniform float u_angle;      // the wanted length of an edge, radians
// square of the length of a chord per distance at which the sphere bulges visibly above it, m
uniform float u_chord;
uniform int u_most;

shared uint s_long[2 * CELL_MOST];
shared vec2 s_diagonals[64];   // sums of squares of rising and of falling ones

vec3 vertex_position(uint first, int a, int b) {
    CellVertex vertex = vertices[first + uint(b * CELL_SIDE + a)];
    return vec3(vertex.x, vertex.y, vertex.z) - u_eye;
}

const float DEVIATION = 0.08;   // of the wanted length: 0.8 pixels at high

// Square of the angle under which `across` is seen from `place`, near enough for small ones.
float angle_squared(vec3 across, vec3 place) {
    float distance2 = max(dot(place, place), 1e-12);
    across -= place * (dot(across, place) / distance2);
    return dot(across, across) / distance2;
}

// Falling diagonals have to be shorter than rising ones by this much, so that a cell seen from straight above, where
// both are alike, doesn't fall by rounding.
const float FALLS_BELOW = 0.98;

// Squares of the angles under which the two diagonals of a square of 2 x 2 quads are seen: which one is shorter doesn't
// depend on how many vertices are skipped.
vec2 diagonals(uint first, int k, int l) {
    vec3 a = vertex_position(first, k, l), b = vertex_position(first, k + 2, l);
    vec3 c = vertex_position(first, k, l + 2), d = vertex_position(first, k + 2, l + 2);
    return vec2(angle_squared(d - a, 0.5 * (a + d)), angle_squared(b - c, 0.5 * (b + c)));
}

bool too_long(uint first, ivec2 from, ivec2 to, float limit) {
    vec3 a = vertex_position(first, from.x, from.y), b = vertex_position(first, to.x, to.y);
    vec3 middle = 0.5 * (a + b);
    ivec2 between = (from + to) / 2;
    vec3 left_out = vertex_position(first, between.x, between.y);
    return angle_squared(b - a, middle) > limit || dot(b - a, b - a) > u_chord * length(middle)
        || angle_squared(left_out - middle, middle) > limit * DEVIATION * DEVIATION;
}

void main() {
    uint cell = gl_WorkGroupID.x, first = cell * uint(CELL_VERTICES);
    if (gl_LocalInvocationID.x < uint(2 * CELL_MOST)) s_long[gl_LocalInvocationID.x] = 0u;
    vec2 sums = vec2(0.0);
    const int HALF = CELL_QUADS / 2;
    for (int k = int(gl_LocalInvocationID.x); k < HALF * HALF; k += 64) {
        sums += diagonals(first, 2 * (k % HALF), 2 * (k / HALF));
    }
    s_diagonals[gl_LocalInvocationID.x] = sums;
    barrier();
    float limit = u_angle * u_angle;
    for (int skip = 1; skip <= u_most; ++skip) {
        int stride = 1 << skip, count = CELL_QUADS / stride;
        uint too_long_i = 0u, too_long_j = 0u;
        for (int k = int(gl_LocalInvocationID.x); k < count * (count + 1); k += 64) {
            int along = (k % count) * stride, across = (k / count) * stride;
            if (too_long(first, ivec2(along, across), ivec2(along + stride, across), limit)) ++too_long_i;
            if (too_long(first, ivec2(across, along), ivec2(across, along + stride), limit)) ++too_long_j;
        }
        atomicAdd(s_long[2 * skip - 2], too_long_i);
        atomicAdd(s_long[2 * skip - 1], too_long_j);
    }
    barrier();
    if (gl_LocalInvocationID.x == 0u) {
        vec2 sums = vec2(0.0);
        for (int k = 0; k < 64; ++k) sums += s_diagonals[k];
        cells[cell].variant = sums.y < FALLS_BELOW * sums.x ? 1u : 0u;
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
