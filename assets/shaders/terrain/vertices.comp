// The vertices of all selected cells, once per snap of the proxy: a workgroup a cell. A vertex is a function of its
// canonical integer lattice point and of the proxy alone, so cells that share it get the same bits whatever their
// levels.
#include "generated/bindings.glsl"
#include "generated/frame.glsl"
#include "generated/planet.glsl"
#include "generated/terrain_grid.glsl"
#include "common/cells.glsl"
#include "common/lattice.glsl"
#include "common/octahedral.glsl"
#include "common/spread.glsl"
#include "terrain/height.glsl"
#include "terrain/attributes.glsl"
#include "terrain/grid_spacing.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = CELL_BUFFER) readonly buffer CellBuffer { Cell cells[]; };
layout(std430, binding = VERTEX_BUFFER) writeonly buffer VertexBuffer { CellVertex vertices[]; };
layout(std430, binding = BOUNDS_BUFFER) writeonly buffer BoundsBuffer { CellBounds bounds[]; };
// Not of the block of what is drawn: these may be the vertices of the next snap.
uniform float u_spacing_per_distance;
uniform float u_smallest_spacing_m;
uniform float u_proxy_height_m;

shared vec4 s_low[64];
shared vec4 s_high[64];

void main() {
    uint cell_index = spread_group();
    Cell cell = cells[cell_index];
    GridSpacing grid = GridSpacing(u_spacing_per_distance, u_smallest_spacing_m, u_proxy_height_m);
    vec4 low = vec4(3.4e38), high = vec4(-3.4e38);
    int k = int(gl_LocalInvocationID.x);
    do {
        ivec2 point = cell_lattice_point(cell, ivec2(k % CELL_SIDE, k / CELL_SIDE));
        vec3 D = lattice_foot_offset(cell.face, point);
        float spacing = grid_spacing(D, grid);
        TerrainPoint terrain = terrain_point(D, spacing);
        float radius = planet.radius_m;
        float height = frame.anchor_height_m + terrain.dh;
        precise vec3 position = D * (1.0 + height / radius) + frame.anchor_up * terrain.dh;
        vec3 zenith = normalize(frame.anchor_up + D / radius);
        vec3 normal = normalize(zenith - terrain.gradient * (radius / (radius + height)));
        CellVertex vertex;
        vertex.x = position.x;
        vertex.y = position.y;
        vertex.z = position.z;
        vertex.dh = terrain.dh;
        vertex.normal = packSnorm2x16(oct_encode(normal));
        vertex.attributes = packUnorm4x8(terrain_attributes(terrain, height, spacing));
        vertices[cell_index * uint(CELL_VERTICES) + uint(k)] = vertex;
        vec4 bound = vec4(position, terrain.dh);
        low = min(low, bound);
        high = max(high, bound);
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
        bounds[cell_index] = CellBounds(s_low[0].xyz, s_low[0].w, s_high[0].xyz, s_high[0].w);
    }
}
