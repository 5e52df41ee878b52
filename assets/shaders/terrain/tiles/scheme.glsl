// A tile's vertices and edges, by the scheme that cuts the sphere. TILE_LOG2: a tile has (1 << TILE_LOG2) segments a
// side.
//
//   const int TILE_VERTICES, TILE_EDGES, TILE_SAMPLES
//   Pair3 tile_direction(TileRequest tile, int k)
//       unit, planet axes, as common/pair.glsl has it: the same bits from each tile that has the vertex. With TILE_MAKE
//       only; reads tile_tables[tile.table ...]
//   void tile_sample(int n, out int a, out int b)
//       the n-th of TILE_SAMPLES edges of triangles, to measure errors at
//   vec3 tile_foot_offset(TileName name, int k)
//       metres from the anchor's foot, planet axes; likewise the same bits
//   int tile_edge(int k)
//       the edge that a vertex lies on, -1 for inner ones and for corners
//   void tile_even(int k, int edge, int skip, out int a, out int b)
//       the two vertices of which the parent has the mean where vertex k is; both k where the parent has it itself. On
//       an edge (edge >= 0) among the multiples of 2^skip
//   int tile_collapsed(int k, int edge, int skip)
//       the vertex that stands for k on an edge with that skip
#ifndef TILE_LOG2
#error "define TILE_LOG2: a tile has (1 << TILE_LOG2) segments a side"
#endif
#ifdef CELL_TRIANGLES
#include "terrain/tiles/triangle.glsl"
#else
#include "terrain/tiles/quad.glsl"
#endif
