// Cells of the surface lattice, the vertices made for them, and what of them is seen. One layout for every system that
// draws on the lattice; each binds its own buffers to these points.
#ifndef QUADS_LOG2
#error "define QUADS_LOG2: a cell has (1 << QUADS_LOG2) quads a side"
#endif
// With CELL_TILES cells are tiles: vertices, boxes and the visible list go by slots, there is one index list.
#ifdef CELL_TILES
const int CELL_MOST = 0, CELL_LISTS = 1;
#else
const int CELL_MOST = 3;   // at least every 8th vertex along an axis is used: MOST of engine/surface/decimation.py
const int CELL_LISTS = 2 * (CELL_MOST + 1) * (CELL_MOST + 1);
#endif
const int CELL_QUADS = 1 << QUADS_LOG2;
const int CELL_SIDE = CELL_QUADS + 1;
#ifdef CELL_TRIANGLES
// Tiles of the icosphere, terrain/tiles/triangle.glsl: the vertex in the middle; circles around it inside and outside
// of a tile, in units of CELL_QUADS times the largest spacing of its level, for tiles of 16 segments or more.
const int CELL_VERTICES = CELL_SIDE * (CELL_SIDE + 1) / 2;
const int CELL_THIRD = CELL_QUADS / 3;
const int CELL_MIDDLE = CELL_THIRD * (CELL_SIDE + 1) - CELL_THIRD * (CELL_THIRD - 1) / 2;
const float CELL_INNER = 0.165, CELL_OUTER = 0.62;
#else
const int CELL_VERTICES = CELL_SIDE * CELL_SIDE;
const int CELL_MIDDLE = (CELL_QUADS / 2) * (CELL_SIDE + 1);
const float CELL_INNER = 0.33, CELL_OUTER = 0.95;
#endif

#include "generated/cells.glsl"

struct CellVertex {
    float x, y, z;     // metres from the anchor, planet axes
    float dh;          // height above the anchor's, metres
    uint normal;       // octahedral, 2 x snorm16, planet axes
    uint attributes;   // 4 x unorm8, the system's own
};

// The integer lattice point of vertex (a, b), 0 <= a, b <= CELL_QUADS.
ivec2 cell_lattice_point(Cell cell, ivec2 ab) {
    return (ivec2(cell.i, cell.j) << (30 - cell.level)) + ab * (1 << (30 - cell.level - QUADS_LOG2));
}

// Where the vertices and the box of a cell are kept.
#ifdef CELL_TILES
#define CELL_PLACE(cells, row) cells[row].slot
#else
#define CELL_PLACE(cells, row) (row)
#endif

// Along an edge only the vertices that both sides use: no T-junctions.
int cell_masked_vertex(uint edge_mask, int index) {
    ivec2 ab = ivec2(index % CELL_SIDE, index / CELL_SIDE);
    int d_i = ab.x == 0 ? int(edge_mask & 255u) : ab.x == CELL_QUADS ? int((edge_mask >> 8) & 255u) : 0;
    int d_j = ab.y == 0 ? int((edge_mask >> 16) & 255u) : ab.y == CELL_QUADS ? int((edge_mask >> 24) & 255u) : 0;
    ab.y = (ab.y >> d_i) << d_i;
    ab.x = (ab.x >> d_j) << d_j;
    return ab.y * CELL_SIDE + ab.x;
}
