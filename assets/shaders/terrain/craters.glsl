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

float crater_single(float a) { return a; }
float crater_there(uint draws) { return int(draws >> 24) < terrain_table.crater_accept ? 1.0 : 0.0; }
vec2 crater_draws(uint draws) { return vec2(draws & 4095u, draws >> 12 & 4095u) * (1.0 / 4096.0); }

// From a crater's place to f, of the base, or to the fraction of a cell that says the same exactly.
#ifdef TERRAIN_CANONICAL
#define CRATER_FRACTION uvec3
#define CRATER_WAY ivec3
const float CRATER_WAY_CELLS = 1.0 / 4294967296.0;

vec3 crater_fraction(uvec3 fraction) { return noise_single(fraction); }
ivec3 crater_way(vec3 f, uvec3 fraction, ivec3 side, uint hash) {
    return ivec3(fraction - ((uvec3(hash & 1023u, hash >> 10 & 1023u, hash >> 22) * 2u + 1u) << 21));
}
#else
#define CRATER_FRACTION vec3
#define CRATER_WAY vec3
const float CRATER_WAY_CELLS = 1.0;

vec3 crater_fraction(vec3 fraction) { return fraction; }
vec3 crater_way(vec3 f, vec3 fraction, ivec3 side, uint hash) { return f - vec3(side) - crater_place(hash); }
#endif

// The crater at v from its place, in cells, which is also `way`.
TerrainCraterForm crater_form(CraterOctave octave, vec3 v, CRATER_WAY way, uint draws, vec3 up) {
    float vv = dot(v, v), along = dot(v, up), curve = octave.lattice.wavelength_m / terrain_table.radius_m;
    vec2 u = crater_draws(draws);
    TerrainCraterAbove c = terrain_crater_above(vv, along, curve);
#ifdef TERRAIN_CANONICAL
    // vv - z^2 without cancellation where the place is far above the sphere or below it: along + z is small.
    vec3 across = v - along * up;
    float aside = dot(across, across) + (along - c.z) * curve * (vv + along * c.z) / (1.0 + c.root);
#else
    float aside = vv - c.z * c.z;
#endif
    return terrain_crater_form(octave.shape, aside, c.z, c.root, crater_there(draws), u.x, u.y);
}

// Metres with one crater more, `shown` of it.
float crater_over(float total, float shown, float width_m, TerrainCraterForm c) {
    return total * (1.0 - shown * c.covered) + shown * c.form * c.fresh * width_m * c.size;
}

#ifdef TERRAIN_CANONICAL
float crater_single(Pair a) { return a.high; }

TerrainCraterFormPair crater_form(CraterOctave octave, vec3 v, ivec3 way, uint draws, Pair3 up) {
    Pair3 exact = pair_scaled(fixed_number(way), 0.25);
    Pair vv = pair_dot(exact, exact), along = pair_dot(exact, up);
    Pair curve = pair_div(pair(octave.lattice.wavelength_m), terrain_table.radius_m);
    vec2 u = crater_draws(draws);
    TerrainCraterAbovePair c = terrain_crater_above(vv, along, curve);
    return terrain_crater_form(octave.shape, pair_sub(vv, pair_mul(c.z, c.z)), c.z, c.root, pair(crater_there(draws)),
        pair(u.x), pair(u.y));
}

Pair crater_over(Pair total, float shown, float width_m, TerrainCraterFormPair c) {
    Pair height_m = pair_mul(pair_mul(pair_mul(c.form, c.fresh), c.size), shown * width_m);
    return pair_add(pair_mul(total, pair_sub(1.0, pair_mul(c.covered, shown))), height_m);
}
#endif

// Metres that one octave adds at the place `fraction` of `cell`, in floats or exactly. up: the foot on the sphere over
// the radius; spacing_m limits heights to what vertices that far apart may need. ground: adds what spacing_m shows of
// the gradient and begin_m does not (begin_m 0: all), and how freshly dug it is.
#define TERRAIN_CRATER_OCTAVE(REAL, UP, FORM, ZERO) \
    REAL terrain_crater_octave( \
        CraterOctave octave, ivec3 cell, CRATER_FRACTION fraction, UP up, float spacing_m, float begin_m, \
        inout TerrainSources ground \
    ) { \
        float width_m = octave.lattice.wavelength_m; \
        vec3 f = crater_fraction(fraction) - 0.5; \
        ivec3 below = ivec3(lessThan(f, vec3(0.0))); \
        ivec3 base = cell - below; \
        f += vec3(below) + 0.5; \
        uvec3 firsts = uvec3(base) * CRATER_STEPS; \
        uint first = firsts.x + firsts.y + firsts.z; \
        int reached = 0; \
        for (int parity = 0; parity < 8; ++parity) { \
            ivec3 side = crater_side(base, parity); \
            vec3 v = f - vec3(side) - crater_place(crater_hash(first, side)); \
            reached |= dot(v, v) < 0.25001 ? 1 << parity : 0; \
        } \
        REAL total = ZERO; \
        TerrainSources found = NO_SOURCES; \
        while (reached != 0) { \
            ivec3 side = crater_side(base, findLSB(reached)); \
            uint hash = crater_hash(first, side), draws = crater_mix(hash ^ 0x68bc21ebu); \
            reached &= reached - 1; \
            CRATER_WAY way = crater_way(f, fraction, side, hash); \
            vec3 v = vec3(way) * CRATER_WAY_CELLS; \
            FORM c = crater_form(octave, v, way, draws, up); \
            float size = crater_single(c.size), wide_m = 2.0 * size * width_m; \
            float seen = terrain_layer_weight(wide_m, spacing_m) \
                - (begin_m > 0.0 ? terrain_layer_weight(wide_m, begin_m) : 0.0); \
            float steep = size * crater_single(c.fresh) * c.slope - crater_single(total) / width_m * c.covered_slope; \
            crater_show(seen, crater_single(c.covered), 2.0 * c.square_by_vv * steep * v, c.dug, found); \
            total = crater_over(total, terrain_height_weight(wide_m, spacing_m), width_m, c); \
        } \
        ground.gradient += found.gradient; \
        ground.dug += found.dug; \
        return total; \
    }

TERRAIN_CRATER_OCTAVE(float, vec3, TerrainCraterForm, 0.0)
#ifdef TERRAIN_CANONICAL
TERRAIN_CRATER_OCTAVE(Pair, Pair3, TerrainCraterFormPair, pair(0.0))
#endif
