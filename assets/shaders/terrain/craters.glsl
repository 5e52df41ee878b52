// Impact craters: systems/terrain/craters.py, which says where the numbers come from; its crater_form.py has the
// statements of a single one. An octave is a 3D lattice with a crater a cell; eight cells can reach a point. The first
// loop finds those that do (about one in sixteen), the second works them out: on software GPUs that is half the time of
// eight whole craters.
#include "generated/terrain_crater_form.glsl"

const uvec3 CRATER_STEPS = uvec3(0x9E3779B1u, 0x85EBCA77u, 0xC2B2AE3Du);

uint crater_mix(uint x) {
    x = (x ^ x >> 16) * 0x7feb352du;
    x = (x ^ x >> 15) * 0x846ca68bu;
    return x ^ x >> 16;
}

// The hash of the cell at `side` (0 or 1 an axis) of the one whose word is first, and the crater's place in its cell
// from it.
uint crater_hash(uint first, ivec3 side) {
    uvec3 steps = uvec3(-side) & CRATER_STEPS;
    return crater_mix(first + steps.x + steps.y + steps.z);
}

vec3 crater_place(uint hash) {
    return (vec3(hash & 1023u, hash >> 10 & 1023u, hash >> 22) + 0.5) * (1.0 / 1024.0);
}

ivec3 crater_side(ivec3 base, int parity) {
    return (ivec3(parity, parity >> 1, parity >> 2) ^ base) & 1;
}

// What of a crater is `seen` takes the place of older ones where it covers them.
void crater_show(float seen, float covered, vec3 gradient, float dug, inout TerrainSources ground) {
    float kept = 1.0 - seen * covered;
    ground.gradient = ground.gradient * kept + seen * gradient;
    ground.dug = ground.dug * kept + seen * dug;
}

// Metres that one octave adds at the place `fraction` of `cell`, in float or double. up: the foot on the sphere over
// the radius; spacing_m limits heights to what vertices that far apart may need. ground: adds what spacing_m shows of
// the gradient and begin_m does not (begin_m 0: all), and how freshly dug it is.
#define TERRAIN_CRATER_OCTAVE(REAL, REAL3, FORM) \
    REAL terrain_crater_octave( \
        CraterOctave octave, ivec3 cell, REAL3 fraction, REAL3 up, float spacing_m, float begin_m, \
        inout TerrainSources ground \
    ) { \
        float width_m = octave.lattice.wavelength_m; \
        REAL curve = REAL(width_m) / REAL(terrain_table.radius_m); \
        REAL3 f = fraction - REAL(0.5); \
        ivec3 below = ivec3(lessThan(f, REAL3(0.0))); \
        ivec3 base = cell - below; \
        f += REAL3(below) + REAL(0.5); \
        uvec3 firsts = uvec3(base) * CRATER_STEPS; \
        uint first = firsts.x + firsts.y + firsts.z; \
        int reached = 0; \
        for (int parity = 0; parity < 8; ++parity) { \
            ivec3 side = crater_side(base, parity); \
            vec3 v = vec3(f) - vec3(side) - crater_place(crater_hash(first, side)); \
            reached |= dot(v, v) < 0.25001 ? 1 << parity : 0; \
        } \
        REAL total = REAL(0.0); \
        TerrainSources found = NO_SOURCES; \
        while (reached != 0) { \
            ivec3 side = crater_side(base, findLSB(reached)); \
            uint hash = crater_hash(first, side), draws = crater_mix(hash ^ 0x68bc21ebu); \
            reached &= reached - 1; \
            REAL3 v = f - REAL3(side) - REAL3(crater_place(hash)); \
            vec2 u = vec2(draws & 4095u, draws >> 12 & 4095u) * (1.0 / 4096.0); \
            REAL vv = dot(v, v), there = int(draws >> 24) < terrain_table.crater_accept ? REAL(1.0) : REAL(0.0); \
            FORM c = terrain_crater_form(octave.shape, vv, vv, dot(v, up), curve, there, REAL(u.x), REAL(u.y)); \
            float wide_m = 2.0 * float(c.size) * width_m; \
            float seen = terrain_layer_weight(wide_m, spacing_m) \
                - (begin_m > 0.0 ? terrain_layer_weight(wide_m, begin_m) : 0.0); \
            float steep = float(c.size) * float(c.fresh) * c.slope - float(total) / width_m * c.covered_slope; \
            crater_show(seen, float(c.covered), 2.0 * c.square_by_vv * steep * vec3(v), c.dug, found); \
            REAL shown = REAL(terrain_height_weight(wide_m, spacing_m)); \
            total = total * (REAL(1.0) - shown * c.covered) \
                + shown * c.form * c.fresh * REAL(width_m) * c.size; \
        } \
        ground.gradient += found.gradient; \
        ground.dug += found.dug; \
        return total; \
    }

TERRAIN_CRATER_OCTAVE(float, vec3, TerrainCraterForm)
#ifdef TERRAIN_CANONICAL
TERRAIN_CRATER_OCTAVE(double, dvec3, TerrainCraterFormDouble)
#endif
