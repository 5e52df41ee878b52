// The sea's vertices: points of the lattice at sea level, and the depth of the ground below them for the colour of
// shallows.
#include "generated/bindings.glsl"
#include "generated/frame.glsl"
#include "generated/planet.glsl"
#include "generated/ocean.glsl"
#include "common/cells.glsl"
#include "common/lattice.glsl"
#include "common/octahedral.glsl"
#include "common/spread.glsl"
#include "contract/surface_height.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = CELL_BUFFER) readonly buffer CellBuffer { Cell cells[]; };
layout(std430, binding = VERTEX_BUFFER) writeonly buffer VertexBuffer { CellVertex vertices[]; };
layout(std430, binding = BOUNDS_BUFFER) writeonly buffer BoundsBuffer { CellBounds bounds[]; };
// of each cell in what follows, or -1
layout(std430, binding = 6) readonly buffer GroundRowBuffer { int ground_row[]; };
layout(std430, binding = 7) readonly buffer GroundBoundsBuffer { CellBounds ground_bounds[]; };

// how far waves move a point
uniform float u_reach_up_m;
uniform float u_reach_m;      // in all
uniform int u_first;    // the first of this part's cells; -1: the ground's boxes are not there

// Ground without water by far is as good as made: heights that differ do so by layers that no vertex can show.
const float DRY_M = 2.0, DRY_SPACINGS = 0.125;

shared vec4 s_low[64];   // w: minus the greatest depth
shared vec3 s_high[64];

void main() {
    uint cell_index = spread_group();
    Cell cell = cells[cell_index];
    float level = planet.sea_level_m, dh = level - frame.anchor_height_m, radius = planet.radius_m;
    bool dry = false;
    if (u_first >= 0) {
        int row = ground_row[uint(u_first) + cell_index];
        dry = row >= 0 && frame.anchor_height_m + ground_bounds[max(row, 0)].low_dh_m > level + DRY_M
            + DRY_SPACINGS * cell.spacing_m;
    }
    vec4 low = vec4(3.4e38);
    vec3 high = vec3(-3.4e38);
    int k = int(gl_LocalInvocationID.x);
    do {
        ivec2 point = cell_lattice_point(cell, ivec2(k % CELL_SIDE, k / CELL_SIDE));
        vec3 D = lattice_foot_offset(cell.face, point);
        precise vec3 position = D * (1.0 + level / radius) + frame.anchor_up * dh;
        float depth = 0.0;
        if (!dry) depth = max(level - surface_height(D, cell.spacing_m), 0.0);
        CellVertex vertex;
        vertex.x = position.x;
        vertex.y = position.y;
        vertex.z = position.z;
        vertex.dh = dh;
        vertex.normal = packSnorm2x16(oct_encode(normalize(frame.anchor_up + D / radius)));
        vertex.attributes = packUnorm2x16(vec2(depth / (depth + 16.0), 0.0));
        vertices[cell_index * uint(CELL_VERTICES) + uint(k)] = vertex;
        low = min(low, vec4(position, -depth));
        high = max(high, position);
        k += 64;
    } while (k < CELL_VERTICES);
    uint lane = gl_LocalInvocationID.x;
    s_low[lane] = low;
    s_high[lane] = high;
    for (uint half_count = 32u; half_count > 0u; half_count >>= 1) {
        barrier();
        if (lane < half_count) {
            s_low[lane] = min(s_low[lane], s_low[lane + half_count]);
            s_high[lane] = max(s_high[lane], s_high[lane + half_count]);
        }
    }
    if (lane == 0u) {
        // No water anywhere in the cell: out of reach of the culling pass's limits.
        bounds[cell_index] = CellBounds(s_low[0].xyz - u_reach_m, dh - u_reach_up_m, s_high[0] + u_reach_m,
            s_low[0].w < 0.0 ? dh + u_reach_up_m : -1.0e30);
    }
}
