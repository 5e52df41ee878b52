// Vertices of a chunk as in "Planetary Terrain" (Ralith): four corners and their normals from float64, a (1 - t) + b t
// between them, the sphere's bulge by the law of sines, the height along the normal; on an edge the low bits of the
// vertex's place are masked by how many levels coarser the neighbour is. No morph. In place of its view space: axes of
// the planet, from our anchor.
#include "generated/bindings.glsl"
#include "common/constants.glsl"
#include "generated/frame.glsl"
#include "generated/planet.glsl"
#include "common/cells.glsl"
#include "generated/chunk_corner.glsl"
#include "generated/tile_slots.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = TILE_ROW_BUFFER) readonly buffer RowBuffer { TileRow rows[]; };
layout(std430, binding = VERTEX_BUFFER) writeonly buffer VertexBuffer { CellVertex vertices[]; };
layout(std430, binding = TILE_SLOT_BUFFER) readonly buffer SlotBuffer { TileVertex slots[]; };
layout(std430, binding = TILE_LIST_BUFFER) readonly buffer ListBuffer { uint list[]; };
layout(std430, binding = 4) readonly buffer CornerBuffer { ChunkCorner corners[]; };   // 4 a row
layout(std430, binding = BOUNDS_BUFFER) writeonly buffer BoundsBuffer { CellBounds bounds[]; };
uniform int u_anchor_height;   // in steps
uniform float u_step_m;

shared vec4 s_low[64];
shared vec4 s_high[64];


// The source's form: mix() may be a + t (b - a), which does not end at b.
vec3 bilerp(vec3 a, vec3 b, vec3 c, vec3 d, vec2 coords) {
    precise vec3 y0 = a * (1.0 - coords.x) + b * coords.x;
    precise vec3 y1 = c * (1.0 - coords.x) + d * coords.x;
    precise vec3 y = y0 * (1.0 - coords.y) + y1 * coords.y;
    return y;
}

void main() {
    uint index = list[gl_WorkGroupID.x];
    TileRow row = rows[index];
    uint lane = gl_LocalInvocationID.x, first = row.slot * uint(CELL_VERTICES), at = 4u * index;
    vec4 low = vec4(3.4e38), high = vec4(-3.4e38);
    for (int k = int(lane); k < CELL_VERTICES; k += 64) {
        int kept = cell_masked_vertex(row.edge_skip, k);
        ivec2 ab = ivec2(kept % CELL_SIDE, kept / CELL_SIDE);
        vec2 coords = vec2(ab) / float(CELL_QUADS);
        vec3 I = bilerp(corners[at].foot_m, corners[at + 1u].foot_m, corners[at + 2u].foot_m, corners[at + 3u].foot_m,
            coords);
        vec3 N = normalize(bilerp(corners[at].normal, corners[at + 1u].normal, corners[at + 2u].normal,
            corners[at + 3u].normal, coords));
        uint nearest = (2 * ab.x > CELL_QUADS ? 1u : 0u) + (2 * ab.y > CELL_QUADS ? 2u : 0u);
        vec3 C = corners[at + nearest].foot_m;
        float CI = length(C - I);
        vec3 X = I;
        if (CI > 0.0) {
            float CIX = acos(clamp(dot((C - I) / CI, N), -1.0, 1.0));
            float COX = acos(min(dot(N, corners[at + nearest].normal), 1.0));
            float CXI = 0.5 * (PI - COX), ICX = PI - CIX - CXI;
            X = I + N * (CI * sin(ICX) / sin(CXI));
        }
        TileVertex vertex = slots[first + uint(kept)];
        float dh = float(vertex.height - u_anchor_height) * u_step_m;
        vec3 position = X + N * (frame.anchor_height_m + dh) - frame.anchor_up * frame.anchor_height_m;
        vertices[first + uint(k)] = CellVertex(position.x, position.y, position.z, dh, vertex.normal,
            vertex.attributes);
        vec4 bound = vec4(position, dh);
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
    if (lane == 0u) bounds[row.slot] = CellBounds(s_low[0].xyz, s_low[0].w, s_high[0].xyz, s_high[0].w);
}
