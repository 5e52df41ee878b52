// Octaves of the height function as changes from the anchor, in float: as exact as the offset from it. With
// TERRAIN_FLOAT their rounding is that of the noises instead, for pixels that are tens of metres wide: within 0.1 m on
// Earth, of which a place thousands of kilometres from the anchor takes the most; half of the time.
#include "common/noise_change.glsl"

// From the anchor to a place, in an octave's cells: by `d` from `from` in `cell`; and where the place is in a cell next
// to the anchor's, which the anchor may be at the edge of, by `rest` from `next_from` in `next`. `plain`: no change,
// but `from` is the place: it is so far that the difference of the two noises does.
struct TerrainWay {
    ivec3 cell, next;
    vec3 from, d, next_from, rest;
    int parts;
    bool plain;
};

const float TERRAIN_PLAIN_CELLS = 0.25;

// always: plain wherever it is.
TerrainWay terrain_way(TerrainLattice lattice, vec3 offset_m, bool always) {
    vec3 t = offset_m * lattice.frequency_per_m, at = lattice.fraction;
    ivec3 cell;
    vec3 fraction;
    terrain_place(lattice, offset_m, cell, fraction);
    bool inside = cell == lattice.cell && !always;
    bool plain = !inside && (always || max(max(abs(t.x), abs(t.y)), abs(t.z)) > TERRAIN_PLAIN_CELLS);
    vec3 d = clamp(t, -at, 1.0 - at), edge = clamp(at + d - vec3(cell - lattice.cell), 0.0, 1.0);
    return TerrainWay(plain ? cell : lattice.cell, cell, plain ? fraction : at, plain ? vec3(0.0) : d, edge, t - d,
        inside || plain ? 1 : 2, plain);
}

vec3 terrain_warp(TerrainLattice lattice, vec3 d, out mat3 jacobian) {
    ivec3 cell;
    vec3 fraction;
    terrain_place(lattice, d, cell, fraction);
    vec3 w = vector_noise(cell, fraction, jacobian);
    jacobian *= lattice.frequency_per_m;
    return w;
}

// How far a warp of value w moves a place against the anchor, metres.
vec3 terrain_bend(TerrainWarp warp, vec3 w) {
    return warp.amplitude_m * (w - warp.value);
}

#ifdef TERRAIN_FLOAT
float terrain_change(TerrainLattice lattice, vec3 d, out vec3 gradient) {
    vec4 n = terrain_noise(lattice, d);
    gradient = n.xyz;
    return n.w - lattice.value;
}

vec3 terrain_warp_change(TerrainWarp warp, vec3 d, out mat3 jacobian) {
    return terrain_warp(warp.lattice, d, jacobian) - warp.value;
}
#else
float terrain_change(TerrainLattice lattice, vec3 d, out vec3 gradient) {
    TerrainWay way = terrain_way(lattice, d, false);
    float change = 0.0;
    vec4 there;
    do {
        change += gradient_noise_change(way.cell, way.from, way.d, there);
        way.cell = way.next;
        way.from = way.next_from;
        way.d = way.rest;
    } while (--way.parts > 0);
    gradient = there.xyz * lattice.frequency_per_m;
    return way.plain ? there.w - lattice.value : change;
}

vec3 terrain_warp_change(TerrainWarp warp, vec3 d, out mat3 jacobian) {
    TerrainWay way = terrain_way(warp.lattice, d, false);
    vec3 change = vec3(0.0), there;
    do {
        change += vector_noise_change(way.cell, way.from, way.d, there, jacobian);
        way.cell = way.next;
        way.from = way.next_from;
        way.d = way.rest;
    } while (--way.parts > 0);
    jacobian *= warp.lattice.frequency_per_m;
    return way.plain ? there - warp.value : change;
}
#endif

// Moves a place by what the warp changes from the anchor to d; returns that.
vec3 terrain_warp_place(inout vec3 place, TerrainWarp warp, vec3 d, out mat3 jacobian) {
    vec3 w = terrain_warp_change(warp, d, jacobian);
    place += warp.amplitude_m * w;
    return w;
}

// Of a layer's value, n: the change of its noise.
float terrain_layer_change(TerrainLayer layer, float n) {
    return terrain_ridge_change(layer.lattice.value, layer.ridge, n);
}
