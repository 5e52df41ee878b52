// Drawable vertices of tiles, relative to the anchor, from the heights in their slots: a workgroup a tile. What lies on
// an edge is a function of lattice points, heights and the edge's skip and morph alone, which both tiles beside it have
// alike.
#include "generated/bindings.glsl"
#include "generated/frame.glsl"
#include "generated/planet.glsl"
#include "common/cells.glsl"
#include "generated/tile_slots.glsl"
#include "terrain/tiles/scheme.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = TILE_ROW_BUFFER) readonly buffer RowBuffer { TileRow rows[]; };
layout(std430, binding = VERTEX_BUFFER) coherent buffer VertexBuffer { CellVertex vertices[]; };
layout(std430, binding = TILE_SLOT_BUFFER) readonly buffer SlotBuffer { TileVertex slots[]; };
layout(std430, binding = TILE_LIST_BUFFER) readonly buffer ListBuffer { uint list[]; };
layout(std430, binding = BOUNDS_BUFFER) writeonly buffer BoundsBuffer { CellBounds bounds[]; };
uniform int u_anchor_height;   // in steps
uniform float u_step_m;

shared vec4 s_low[64];
shared vec4 s_high[64];

// The least and the largest of a tile's vertices, with all invocations, into s_low[0] and s_high[0].
void gather_bounds(uint first) {
    uint lane = gl_LocalInvocationID.x;
    vec4 low = vec4(3.4e38), high = vec4(-3.4e38);
    for (int k = int(lane); k < TILE_VERTICES; k += 64) {
        CellVertex vertex = vertices[first + uint(k)];
        vec4 bound = vec4(vertex.x, vertex.y, vertex.z, vertex.dh);
        low = min(low, bound);
        high = max(high, bound);
    }
    s_low[lane] = low;
    s_high[lane] = high;
    for (uint count = 32u; count > 0u; count >>= 1) {
        barrier();
        if (lane < count) {
            s_low[lane] = min(s_low[lane], s_low[lane + count]);
            s_high[lane] = max(s_high[lane], s_high[lane + count]);
        }
    }
}

void main() {
    TileRow row = rows[list[gl_WorkGroupID.x]];
    uint lane = gl_LocalInvocationID.x, first = row.slot * uint(TILE_VERTICES);
    float radius = planet.radius_m;
    for (int k = int(lane); k < TILE_VERTICES; k += 64) {
        TileVertex kept = slots[first + uint(k)];
        vec3 D = tile_foot_offset(row.name, k);
        precise float dh = float(kept.height - u_anchor_height) * u_step_m;
        precise float height = frame.anchor_height_m + dh;
        precise vec3 position = D * (1.0 + height / radius) + frame.anchor_up * dh;
        vertices[first + uint(k)] = CellVertex(position.x, position.y, position.z, dh, kept.normal, kept.attributes);
    }
    memoryBarrierBuffer();
    barrier();
    // Towards the parent: vertices that it lacks move to the middle of what it has. These are read by others only
    // unmoved.
    float most = max(row.morph, max(max(row.edge_morph.x, row.edge_morph.y), max(row.edge_morph.z, row.edge_morph.w)));
    for (int k = most > 0.0 ? int(lane) : TILE_VERTICES; k < TILE_VERTICES; k += 64) {
        int edge = tile_edge(k), a, b;
        int skip = edge < 0 ? 0 : int((row.edge_skip >> uint(8 * edge)) & 255u);
        float morph = edge < 0 ? row.morph : row.edge_morph[edge];
        tile_even(k, edge, skip, a, b);
        if (a != b && morph > 0.0) {
            CellVertex own = vertices[first + uint(k)], low = vertices[first + uint(a)],
                high = vertices[first + uint(b)];
            precise vec4 middle = 0.5 * (vec4(low.x, low.y, low.z, low.dh) + vec4(high.x, high.y, high.z, high.dh));
            precise vec4 moved = vec4(own.x, own.y, own.z, own.dh) * (1.0 - morph) + middle * morph;
            vertices[first + uint(k)].x = moved.x;
            vertices[first + uint(k)].y = moved.y;
            vertices[first + uint(k)].z = moved.z;
            vertices[first + uint(k)].dh = moved.w;
        }
    }
    memoryBarrierBuffer();
    barrier();
    // Along an edge to a coarser tile only the vertices that both have.
    for (int k = row.edge_skip != 0u ? int(lane) : TILE_VERTICES; k < TILE_VERTICES; k += 64) {
        int edge = tile_edge(k);
        int stands = edge < 0 ? k : tile_collapsed(k, edge, int((row.edge_skip >> uint(8 * edge)) & 255u));
        if (stands != k) vertices[first + uint(k)] = vertices[first + uint(stands)];
    }
    memoryBarrierBuffer();
    barrier();
    gather_bounds(first);
    if (lane == 0u) bounds[row.slot] = CellBounds(s_low[0].xyz, s_low[0].w, s_high[0].xyz, s_high[0].w);
}
