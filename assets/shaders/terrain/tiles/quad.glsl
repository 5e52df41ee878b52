// Tiles of the cube's quadtree: (segments + 1)^2 vertices, k = b * TILE_SIDE + a. Triangles share rising diagonals,
// from (a, b) to (a + 1, b + 1), at all levels, so that a parent's edges run along its children's. Edges 0: i - 1, 1: i
// + 1, 2: j - 1, 3: j + 1.
#include "common/lattice.glsl"
#include "generated/tile_slots.glsl"

const int TILE_SEGMENTS = 1 << TILE_LOG2, TILE_SIDE = TILE_SEGMENTS + 1, TILE_VERTICES = TILE_SIDE * TILE_SIDE;
const int TILE_EDGES = 4;
const int TILE_SAMPLES = min(TILE_SEGMENTS * TILE_SEGMENTS / 4, 128);

#ifdef TILE_MAKE
// The CPU gives the tangents of columns and rows, in pairs of floats. The faces' axes are axes of the planet: no sum
// has more than one part that is not 0.
Pair3 tile_direction(TileRequest tile, int k) {
    vec2 x = tile_tables[tile.table + uint(k % TILE_SIDE)];
    vec2 y = tile_tables[tile.table + uint(TILE_SIDE + k / TILE_SIDE)];
    vec3 along_x = vec3(PF_LATTICE_X[tile.name.root]), along_y = vec3(PF_LATTICE_Y[tile.name.root]);
    return pair_unit(Pair3(x.x * along_x + y.x * along_y + vec3(PF_LATTICE_Z[tile.name.root]),
        x.y * along_x + y.y * along_y));
}

void tile_sample(int n, out int a, out int b) {
    int quad = n * (TILE_SEGMENTS * TILE_SEGMENTS / TILE_SAMPLES), row = quad / TILE_SEGMENTS;
    int column = (quad + 3 * row) % TILE_SEGMENTS;
    a = row * TILE_SIDE + column;
    b = a + TILE_SIDE + 1;
}
#endif

vec3 tile_foot_offset(TileName name, int k) {
    int shift = 30 - name.level;
    return lattice_foot_offset(name.root, (ivec2(name.i, name.j) << shift)
        + (ivec2(k % TILE_SIDE, k / TILE_SIDE) << (shift - TILE_LOG2)));
}

int tile_edge(int k) {
    ivec2 ab = ivec2(k % TILE_SIDE, k / TILE_SIDE);
    bvec2 low = equal(ab, ivec2(0)), high = equal(ab, ivec2(TILE_SEGMENTS));
    bool x = low.x || high.x, y = low.y || high.y;
    return x == y ? -1 : x ? (high.x ? 1 : 0) : (high.y ? 3 : 2);
}

void tile_even(int k, int edge, int skip, out int a, out int b) {
    ivec2 ab = ivec2(k % TILE_SIDE, k / TILE_SIDE);
    ivec2 along = edge < 0 ? ivec2(1) : edge < 2 ? ivec2(0, 1) : ivec2(1, 0);
    ivec2 odd = ((ab >> skip) & 1) * along;   // the parent's diagonal where both are
    a = k - ((odd.y * TILE_SIDE + odd.x) << skip);
    b = k + ((odd.y * TILE_SIDE + odd.x) << skip);
}

int tile_collapsed(int k, int edge, int skip) {
    ivec2 ab = ivec2(k % TILE_SIDE, k / TILE_SIDE);
    if (edge == 0 || edge == 1) ab.y = (ab.y >> skip) << skip;
    if (edge == 2 || edge == 3) ab.x = (ab.x >> skip) << skip;
    return ab.y * TILE_SIDE + ab.x;
}
