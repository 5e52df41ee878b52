// The height of the ground as a function of the direction from the planet's centre alone, all layers, whatever spacing
// its gradient is band-limited to. Whoever evaluates it at the same bits gets the same bits, at any level of detail and
// time. The table has to be the one around the planet's centre (height_table.canonical_table).
//
//   TerrainPoint terrain_canonical(Pair3 up, float spacing_m, out Pair height_m)    dh is the height as a float
#define TERRAIN_CANONICAL
#include "terrain/height.glsl"

// Heights as integers, in steps of a power of two that suits the planet's relief: the same bits are the same height.
int height_fixed(Pair height_m, float steps_per_m) {
    Pair steps = pair_scaled(height_m, steps_per_m);
    float whole = floor(steps.high);
    return int(whole) + int(floor((steps.high - whole) + steps.low + 0.5));
}

TerrainPoint terrain_canonical(Pair3 up, float spacing_m, out Pair height_m) {
    float units = terrain_table.radius_m / terrain_table.fixed_unit_m;
    Fixed3 place = fixed_place(pair_mul(up, vec3(units)));
    return terrain_point(terrain_broad(place), place, spacing_m, height_m);
}
