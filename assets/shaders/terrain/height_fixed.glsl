// Octaves of the height function around the planet's centre: places in fixed point, in units of
// terrain_table.fixed_unit_m, values as pairs of floats, and nothing is a difference from an anchor. The counterpart of
// terrain/height_change.glsl.

// Value and gradient apart.
Pair terrain_change(TerrainLattice lattice, Fixed3 d, out vec3 gradient) {
    ivec3 cell;
    uvec3 fraction;
    terrain_place(lattice, d, cell, fraction);
    Pair n = fixed_number(gradient_noise(cell, fraction, gradient));
    gradient *= lattice.frequency_per_m;
    return n;
}

// Moves a place by what the warp is at d; returns that.
Pair3 terrain_warp_place(inout Fixed3 place, TerrainWarp warp, Fixed3 d, out mat3 jacobian) {
    ivec3 cell;
    uvec3 fraction;
    terrain_place(warp.lattice, d, cell, fraction);
    ivec3 w = vector_noise(cell, fraction, jacobian);
    jacobian *= warp.lattice.frequency_per_m;
    place = fixed_add(place, fixed_product(w, warp.factor, warp.shift));
    return fixed_number(w);
}

// A layer's value from its noise.
Pair terrain_layer_change(TerrainLayer layer, Pair n) {
    return terrain_ridge(n, pair(layer.ridge));
}
