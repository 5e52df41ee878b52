// The height of the ground as a function of the place alone: P in double from the planet's centre, all layers, whatever
// spacing its gradient is band-limited to. Whoever evaluates it at the same P gets the same bits, at any level of
// detail and time. The table has to be the one around the planet's centre
// (height_table.canonical_table).
//
//   TerrainPoint terrain_canonical(dvec3 P, float spacing_m, out double height_m)    dh is the height as a float
#define TERRAIN_CANONICAL
#include "terrain/height.glsl"

// Heights as integers, in steps of a power of two that suits the planet's relief: the same bits are the same height.
int height_fixed(double height_m, float steps_per_m) {
    return int(floor(height_m * double(steps_per_m) + 0.5LF));
}

TerrainPoint terrain_canonical(dvec3 P, float spacing_m, out double height_m) {
    return terrain_point(terrain_broad(P), P, spacing_m, height_m);
}
