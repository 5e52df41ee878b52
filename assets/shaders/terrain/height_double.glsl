// Octaves of the height function around the planet's centre, in double: places are P itself, and nothing is a
// difference from an anchor. The counterpart of terrain/height_change.glsl.
#include "common/noise_double.glsl"

#define TERRAIN_PLACE dvec3
#define TERRAIN_REAL double
#define TERRAIN_REAL2 dvec2
#define TERRAIN_REAL3 dvec3

void terrain_place(TerrainLattice lattice, dvec3 d, out ivec3 cell, out dvec3 fraction) {
    dvec3 t = d * double(lattice.frequency_per_m) + (dvec3(lattice.fraction_hi) + dvec3(lattice.fraction_lo));
    dvec3 whole = floor(t);
    fraction = t - whole;
    cell = lattice.cell + ivec3(whole);
}

// Noise of an octave at P: xyz gradient by metres, w value.
vec4 terrain_noise(TerrainLattice lattice, dvec3 d) {
    ivec3 cell;
    dvec3 fraction;
    terrain_place(lattice, d, cell, fraction);
    vec4 n = gradient_noise(cell, vec3(fraction));
    n.xyz *= lattice.frequency_per_m;
    return n;
}

// Value and gradient apart, the value as precise as the offset.
double terrain_change(TerrainLattice lattice, dvec3 d, out vec3 gradient) {
    ivec3 cell;
    dvec3 fraction;
    terrain_place(lattice, d, cell, fraction);
    double n = gradient_noise_double(cell, fraction, gradient);
    gradient *= lattice.frequency_per_m;
    return n;
}

dvec3 terrain_warp_change(TerrainWarp warp, dvec3 d, out mat3 jacobian) {
    ivec3 cell;
    dvec3 fraction;
    terrain_place(warp.lattice, d, cell, fraction);
    dvec3 w = vector_noise_double(cell, fraction, jacobian);
    jacobian *= warp.lattice.frequency_per_m;
    return w;
}

// A layer's value from its noise.
double terrain_layer_change(TerrainLayer layer, double n) {
    return terrain_ridge(n, double(layer.ridge));
}
