// Wide craters as changes from the anchor, in float: as exact as the offset from it. As terrain/craters.glsl; d_ stands
// for changes, new_ for values at the second place, as systems/terrain/crater_form.py makes them.

// Change, in metres, of what an octave adds between two places: `from`, in cells of the eight cells at `base`, and
// `from` + d. to_foot: from `from` to the one of both that lies on the sphere; up: the latter over the radius. before:
// metres that the octave adds at `from`. ground: as terrain_crater_octave, at `from` + d.
float terrain_crater_way(CraterOctave octave, ivec3 base, vec3 from, vec3 d, vec3 to_foot, vec3 up, float spacing_m,
    out float before, out TerrainSources ground) {
    float width_m = octave.lattice.wavelength_m, curve = width_m / terrain_table.radius_m;
    uvec3 firsts = uvec3(base) * CRATER_STEPS;
    uint first = firsts.x + firsts.y + firsts.z;
    int reached = 0;
    for (int parity = 0; parity < 8; ++parity) {
        ivec3 side = crater_side(base, parity);
        vec3 v = from - vec3(side) - crater_place(crater_hash(first, side)), w = v + d;
        reached |= min(dot(v, v), dot(w, w)) < 0.25001 ? 1 << parity : 0;
    }
    float change = 0.0;
    before = 0.0;
    ground = NO_SOURCES;
    while (reached != 0) {
        ivec3 side = crater_side(base, findLSB(reached));
        uint hash = crater_hash(first, side), draws = crater_mix(hash ^ 0x68bc21ebu);
        reached &= reached - 1;
        vec3 v = from - vec3(side) - crater_place(hash), w = v + d, foot = v + to_foot;
        vec2 u = vec2(draws & 4095u, draws >> 12 & 4095u) * (1.0 / 4096.0);
        float there = int(draws >> 24) < terrain_table.crater_accept ? 1.0 : 0.0;
        TerrainCraterAbove above = terrain_crater_above(dot(foot, foot), dot(foot, up), curve);
        TerrainCraterFormChange c = terrain_crater_form_change(octave.shape, dot(v, v) - above.z * above.z, above.z,
            above.root, there, u.x, u.y, dot(d, v + w));
        float wide_m = 2.0 * c.size * width_m, seen = terrain_layer_weight(wide_m, spacing_m);
        float steep = c.size * c.fresh * c.new_slope - (before + change) / width_m * c.new_covered_slope;
        crater_show(seen, c.new_covered, 2.0 * c.square_by_vv * steep * w, c.new_dug, ground);

        float shown = terrain_height_weight(wide_m, spacing_m), height_m = shown * c.fresh * width_m * c.size;
        change = change * (1.0 - shown * c.new_covered) - before * (shown * c.d_covered) + height_m * c.d_form;
        before = before * (1.0 - shown * c.covered) + height_m * c.form;
    }
    return change;
}

// Metres of an octave at offset D (up: the place over the radius) less those at the anchor.
float terrain_crater_change(CraterOctave octave, vec3 D, vec3 up, float spacing_m, inout TerrainSources ground) {
    TerrainLattice corners = octave.lattice;  // half a cell on: those of the eight cells that reach a place
    vec3 middle = corners.fraction - 0.5, below = vec3(lessThan(middle, vec3(0.0)));
    corners.cell -= ivec3(below);
    corners.fraction = middle + below;
    // Of wide spacings heights do not show all that is at the anchor.
    TerrainWay way = terrain_way(corners, D, spacing_m > octave.lattice.wavelength_m);
    vec3 to_foot = vec3(0.0), foot_up = way.plain ? up : terrain_table.up;
    float change = 0.0, before;
    TerrainSources found;
    do {
        change += terrain_crater_way(octave, way.cell, way.from + 0.5, way.d, to_foot, foot_up, spacing_m, before,
            found);
        way.cell = way.next;
        way.from = way.next_from;
        way.d = to_foot = way.rest;
        foot_up = up;
    } while (--way.parts > 0);
    ground.gradient += found.gradient;
    ground.dug += found.dug;
    return way.plain ? before - octave.lattice.value : change;
}
