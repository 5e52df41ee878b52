// The vertices of the overlay: where they lie on the new surface, and for cells that change, where on the old one.
// Vertices that both selections have don't move: they start where they end. A workgroup a cell.
#include "generated/bindings.glsl"
#include "terrain/fade/locate.glsl"
#include "common/octahedral.glsl"
#include "common/spread.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = CELL_BUFFER) readonly buffer CellBuffer { Cell cells[]; };
layout(std430, binding = VERTEX_BUFFER) writeonly buffer VertexBuffer { CellVertex vertices[]; };
layout(std430, binding = FADE_START_BUFFER) writeonly buffer StartBuffer { FadeStart starts[]; };
layout(std430, binding = FADE_OLD_BUFFER) readonly buffer OldBuffer { CellVertex old_vertices[]; };
layout(std430, binding = FADE_BUFFER) buffer FadeBuffer { FadeCell fade[]; };
layout(std430, binding = BOUNDS_BUFFER) writeonly buffer BoundsBuffer { CellBounds bounds[]; };
layout(std430, binding = FADE_NEW_BUFFER) readonly buffer NewBuffer { CellVertex new_vertices[]; };
uniform vec3 u_shift;   // the old anchor from the new one, m
uniform float u_rise;   // heights of the old anchor above the new one's, m

shared vec4 s_low[64];
shared vec4 s_high[64];

vec3 place_of(CellVertex v) {
    return vec3(v.x, v.y, v.z);
}

// Shares are added in an order that doesn't depend on which end of an edge comes first.
#define FADE_MIX(a, b, c, share) ((a) * (share).x + (b) * (share).y + (c) * (share).z)

CellVertex fade_mix(CellVertex a, CellVertex b, CellVertex c, vec3 share) {
    precise vec3 position = FADE_MIX(place_of(a), place_of(b), place_of(c), share);
    precise float dh = FADE_MIX(a.dh, b.dh, c.dh, share);
    vec3 normal = FADE_MIX(oct_decode(unpackSnorm2x16(a.normal)), oct_decode(unpackSnorm2x16(b.normal)),
        oct_decode(unpackSnorm2x16(c.normal)), share);
    vec4 attributes = FADE_MIX(unpackUnorm4x8(a.attributes), unpackUnorm4x8(b.attributes), unpackUnorm4x8(c.attributes),
        share);
    CellVertex made;
    made.x = position.x;
    made.y = position.y;
    made.z = position.z;
    made.dh = dh;
    made.normal = packSnorm2x16(oct_encode(normalize(normal)));
    made.attributes = packUnorm4x8(attributes);
    return made;
}

// The least and the largest of all invocations into s_low[0] and s_high[0].
void gather_bounds(vec4 low, vec4 high) {
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
}

void main() {
    uint cell_index = spread_group();
    Cell cell = cells[cell_index];
    FadeCell known = fade[cell_index];
    uint code = uint(cell.level) | cell.variant << 8;
    bool as_new = code == known.new_code && cell.edge_mask == known.new_mask;
    bool changed = known.old_row >= 0 && !(as_new && known.old_code == known.new_code
        && known.old_mask == known.new_mask);
    int finer_new = cell.level - int(known.new_code & 255u), finer_old = cell.level - int(known.old_code & 255u);
    ivec2 from_new = (ivec2(cell.i, cell.j) & ((1 << finer_new) - 1)) * CELL_QUADS;
    ivec2 from_old = (ivec2(cell.i, cell.j) & ((1 << finer_old) - 1)) * CELL_QUADS;
    uint first_new = uint(known.new_row * CELL_VERTICES), first_old = uint(max(known.old_row, 0) * CELL_VERTICES);
    vec4 low = vec4(3.4e38), high = vec4(-3.4e38);
    int k = int(gl_LocalInvocationID.x);
    do {
        ivec2 ab = ivec2(k % CELL_SIDE, k / CELL_SIDE);
        uint at = cell_index * uint(CELL_VERTICES) + uint(k);
        CellVertex end = new_vertices[first_new + uint(k)];
        ivec3 index;
        vec3 share;
        bool own_new = true;
        if (!as_new) {
            fade_locate(finer_new, known.new_mask, known.new_code >> 8, from_new + ab, index, share);
            own_new = share.x == 1.0;
            end = new_vertices[first_new + uint(index.x)];
            if (!own_new) {
                end = fade_mix(end, new_vertices[first_new + uint(index.y)], new_vertices[first_new + uint(index.z)],
                    share);
            }
        }
        if (changed) {
            fade_locate(finer_old, known.old_mask, known.old_code >> 8, from_old + ab, index, share);
            bool own_old = share.x == 1.0;
            CellVertex start = old_vertices[first_old + uint(index.x)];
            if (!own_old) {
                start = fade_mix(start, old_vertices[first_old + uint(index.y)],
                    old_vertices[first_old + uint(index.z)], share);
            }
            uvec4 on_edge = uvec4(equal(ab.xxyy, ivec4(0, CELL_QUADS, 0, CELL_QUADS)));
            bool held = (known.held & (on_edge.x | on_edge.y << 1 | on_edge.z << 2 | on_edge.w << 3)) != 0u;
            bool stays = held || (own_new && own_old);
            precise vec3 place = stays ? place_of(end) : place_of(start) + u_shift;
            starts[at] = FadeStart(place, held ? end.normal : start.normal);
            vec4 bound = vec4(place, stays ? end.dh : start.dh + u_rise);
            low = min(low, bound);
            high = max(high, bound);
        }
        vertices[at] = end;
        vec4 bound = vec4(place_of(end), end.dh);
        low = min(low, bound);
        high = max(high, bound);
        k += 64;
    } while (k < CELL_VERTICES);
    gather_bounds(low, high);
    if (gl_LocalInvocationID.x == 0u) {
        bounds[cell_index] = CellBounds(s_low[0].xyz, s_low[0].w, s_high[0].xyz, s_high[0].w);
        fade[cell_index].changed = changed ? 1u : 0u;
    }
}
