// Tiles of the icosphere: (segments + 1)(segments + 2) / 2 vertices; engine/surface/triangle_patch.py. Vertex (p, q) is
// p steps from corner 0 towards corner 1 and q towards corner 2; rows of constant q follow one another. Edge e runs
// from corner e to e + 1, and t is rounded down along it: all the way round, so that of two edges at a corner one
// rounds towards it.
#include "common/icosphere.glsl"
#include "generated/tile_slots.glsl"

const int TILE_SEGMENTS = 1 << TILE_LOG2, TILE_VERTICES = (TILE_SEGMENTS + 1) * (TILE_SEGMENTS + 2) / 2;
const int TILE_EDGES = 3;
const int TILE_UPRIGHT = TILE_SEGMENTS * (TILE_SEGMENTS + 1) / 2, TILE_SAMPLES = min(TILE_UPRIGHT, 128);

// (p, q) of the k-th vertex of a triangle with so many segments a side: triangular numbers, counted from the end.
ivec2 pf_triangle_place(int k, int segments) {
    int behind = (segments + 1) * (segments + 2) / 2 - 1 - k;
    int row = int(0.5 * sqrt(8.0 * float(behind) + 1.0) - 0.5 + 1.0e-3);
    return ivec2(row - (behind - row * (row + 1) / 2), segments - row);
}

int pf_triangle_index(ivec2 pq) {
    return pq.y * (TILE_SEGMENTS + 1) - pq.y * (pq.y - 1) / 2 + pq.x;
}

// Lattice coordinates.
ivec2 pf_triangle_lattice(TileName name, ivec2 pq) {
    int shift = 30 - name.level, turned = name.j & 1;
    ivec2 corner = (ivec2(name.i, name.j >> 1) + turned) << shift;
    return corner + (1 - 2 * turned) * (pq << (shift - TILE_LOG2));
}

int pf_triangle_along(ivec2 pq, int edge) {
    return edge == 0 ? pq.x : edge == 1 ? pq.y : TILE_SEGMENTS - pq.y;
}

int pf_triangle_on_edge(int edge, int t) {
    return pf_triangle_index(edge == 0 ? ivec2(t, 0)
        : ivec2(edge == 1 ? TILE_SEGMENTS - t : 0, edge == 1 ? t : TILE_SEGMENTS - t));
}

#ifdef TILE_MAKE
Pair3 tile_direction(TileRequest tile, int k) {
    return triangle_direction(tile.name.root, pf_triangle_lattice(tile.name, pf_triangle_place(k, TILE_SEGMENTS)));
}

// An edge of an upright triangle, of each of the three directions in turn.
void tile_sample(int n, out int a, out int b) {
    ivec2 pq = pf_triangle_place(n * TILE_UPRIGHT / TILE_SAMPLES, TILE_SEGMENTS - 1);
    ivec2 from = n % 3 == 2 ? pq + ivec2(0, 1) : pq, to = n % 3 == 1 ? pq + ivec2(0, 1) : pq + ivec2(1, 0);
    a = pf_triangle_index(from);
    b = pf_triangle_index(to);
}
#endif

vec3 tile_foot_offset(TileName name, int k) {
    return triangle_foot_offset(name.root, pf_triangle_lattice(name, pf_triangle_place(k, TILE_SEGMENTS)));
}

int tile_edge(int k) {
    ivec2 pq = pf_triangle_place(k, TILE_SEGMENTS);
    int r = TILE_SEGMENTS - pq.x - pq.y;
    if (max(r, max(pq.x, pq.y)) == TILE_SEGMENTS) return -1;
    return pq.y == 0 ? 0 : r == 0 ? 1 : pq.x == 0 ? 2 : -1;
}

void tile_even(int k, int edge, int skip, out int a, out int b) {
    ivec2 pq = pf_triangle_place(k, TILE_SEGMENTS);
    if (edge < 0) {
        ivec2 odd = pq & 1;
        ivec2 along = odd.x == 1 ? ivec2(1, -odd.y) : odd;   // both odd: the third direction
        a = pf_triangle_index(pq - along);
        b = pf_triangle_index(pq + along);
    } else {
        int t = pf_triangle_along(pq, edge), by = 1 << skip;
        if ((t & (2 * by - 1)) != by) by = 0;
        a = pf_triangle_on_edge(edge, t - by);
        b = pf_triangle_on_edge(edge, t + by);
    }
}

int tile_collapsed(int k, int edge, int skip) {
    if (edge < 0) return k;
    int t = pf_triangle_along(pf_triangle_place(k, TILE_SEGMENTS), edge);
    return pf_triangle_on_edge(edge, (t >> skip) << skip);
}
