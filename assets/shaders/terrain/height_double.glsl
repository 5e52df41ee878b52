// Octaves of the height function around the planet's centre, in double: places are P itself, and nothing is a
// difference from an anchor. The counterpart of terrain/height_change.glsl.

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
    return terrain_warp(warp.lattice, d, jacobian);
}

// A layer's value from its noise.
double terrain_layer_change(TerrainLayer layer, double n) {
    return terrain_ridge(n, double(layer.ridge));
}
