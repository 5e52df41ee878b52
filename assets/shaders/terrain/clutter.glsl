// What stands on the ground near the camera: pebbles and tufts of grass, stones and tussocks, boulders and shrubs, at
// most one in a cell of a square lattice, and inside it, so that no neighbour has to be asked. The pixel's ray is
// followed from the ground back towards the camera through the cells that it crosses, so things have sides, hide one
// another, and throw shadows; the ground's own depth stays. Heights count from the ground as if it were level, so
// nothing floats. Sizes are the world's. A kind goes where pixels grow as large as its things, and from there on it
// costs nothing.
#include "terrain/material.glsl"
#include "common/nested_noise.glsl"
#include "common/surfaces.glsl"
#include "terrain/lattice_axes.glsl"

struct GroundClutter {
    float cover;   // 0..1: share of the pixel with one in front
    float tint;    // -1..1, the same all over one
    float plant;   // 0: stone, 1: plant
    float bush;    // 1: a plant of the largest kind
    float light;   // 0..1: what neighbouring leaves leave to a plant, 1 at its top
    vec3 normal;   // cover times that of its surface, where the ground's is the zenith
    float sun;     // 0..1: what the others leave of the sun to the ground
    float sky;     // 0..1: the same of the sky
    vec3 bloom;    // albedo of flowers times their share
    float bloomed; // share of it that is flowers
    float dry;     // 0..1: how much of grass is straw
};

const int CLUTTER_MOST = 6;        // cells on a ray
const float CLUTTER_REACH = 3.0;   // how far a ray is followed, in cells

// Radii in cells. tall: height over radius.
struct ClutterKind {
    float span_m;     // what a pixel spans where it is gone; the largest is that of near tiles
    int octave;         // cells of NESTED_BASE_M times 2 to this
    float plant_from, plant_to, stone_from, stone_to;   // radii
    float plant_tall, stone_tall;
    float shade;      // share of the sun that is lost behind a plant
    float from_above; // how much a plant is lit from above
};
const ClutterKind CLUTTER[] = ClutterKind[](
    ClutterKind(0.03, 1, 0.12, 0.34, 0.08, 0.30, 2.2, 0.7, 0.5, 0.6),
    ClutterKind(0.1, 3, 0.08, 0.30, 0.08, 0.28, 1.1, 0.65, 0.7, 0.6),
#ifdef GROUND_COVER
    ClutterKind(0.5, 6, 0.06, 0.20, 0.03, 0.11, 0.85, 0.8, 0.85, 0.3));
#else
    ClutterKind(0.5, 6, 0.06, 0.20, 0.03, 0.11, 0.85, 0.8, 0.85, 0.3),
    ClutterKind(NEAR_ACROSS_M, 7, 0.10, 0.40, 0.01, 0.05, 1.25, 0.8, 0.85, 0.2));
#endif

// How much of a beach a place is, from the height at its foot: what stands there hangs on the ground there, not on the
// ground that a ray comes to behind it, and has none of the noise in material.glsl, which would cut through things at
// its edge.
struct ClutterBeach {
    float here;    // at the pixel's ground
    vec2 slope;    // and how that changes, per metre along the lattice's axes
};

ClutterBeach clutter_beach(vec3 up, vec3 slope, float above_sea, float beach_m) {
    float per_m = -2.5 / (beach_m + 1e-3);
    return ClutterBeach(2.5 + per_m * above_sea, per_m * (slope.xy - slope.z / up.z * up.xy));
}

// What stands in one cell, by chance.
struct ClutterThing {
    float there;          // 0..1: how much of it shows
    bool leaves;          // a plant, or else a stone
    float radius, tall;   // in cells; height over radius
    vec2 foot;            // its middle, in the cell
    float tint, turn;
};

// corner: of the cell from the pixel, in cells; here: how much shows of the kind; plants, stones: shares of cells.
ClutterThing clutter_thing(
    int kind, ivec2 column, vec2 corner, float size, ClutterBeach strand, float here, float plants, float stony
) {
    ClutterKind of = CLUTTER[kind];
    uvec2 seed = uvec2(column + 71) * 1664525u + 1013904223u;
    ivec3 bits = lattice_hash(seed.x, seed.y, uint(kind) * 747796405u + 2891336453u);
    vec3 place = vec3(bits & 0xfff) * (1.0 / 4095.0), more = vec3((bits >> 12) & 0xfff) * (1.0 / 4095.0);
    // Plants stand in groups.
    vec2 group = vec2(column & 4095) * (1.0 / 4096.0);
    float dense = clutter_wave(241.0 * group.x + 0.4 * clutter_wave(151.0 * group.y))
        + clutter_wave(199.0 * group.y + 0.4 * clutter_wave(113.0 * group.x));
    float beach = clamp(strand.here + dot(strand.slope, size * (corner + 0.5 * place.xy)), 0.0, 1.0);
    bool leaves = more.y < (plants - BEACH_TAKES.y * plants * beach) * clamp(0.8 + 0.5 * dense, 0.1, 1.0);
    float radius = leaves ? mix(of.plant_from, of.plant_to, more.x * more.x)
        : mix(of.stone_from, of.stone_to, more.x * more.x * more.x);
    float stones = (stony - BEACH_TAKES.x * stony * beach) * clamp(0.7 - 0.5 * dense, 0.1, 1.0);
    return ClutterThing(leaves || more.y > 1.0 - stones ? here : 0.0, leaves, radius,
        leaves ? of.plant_tall : of.stone_tall, mix(vec2(radius), vec2(1.0 - radius), place.xy),
        2.0 * place.z - 1.0, 6.0 * more.z);
}

// A ray through the cells of a kind, first from the ground to the eye, then towards the sun. In cells.
struct ClutterRay {
    vec3 ray;       // along the ground
    float rise;     // and up, for each cell along it
    float along;    // from the pixel's ground
    vec2 at;        // in the cell
    vec2 corner;    // of the cell, from the pixel's ground
    ivec2 column;   // the cell
    bool seeing;    // to the eye
};

void next_cell(inout ClutterRay r) {
    vec2 wall = (step(0.0, r.ray.xy) - r.at) / (r.ray.xy + vec2(1e-9));
    float t = max(min(wall.x, wall.y), 0.0) + 1e-4;
    r.along += r.seeing ? -t : t;
    r.at += t * r.ray.xy;
    vec2 over = floor(r.at);
    r.column += ivec2(over);
    r.corner += over;
    r.at -= over;
}

// Where the ray meets a thing, which is an ellipsoid with a ragged outline.
struct ClutterHit {
    float cover;    // 0..1
    vec3 normal;    // of unit length inside, in the space where the thing is round
    vec3 level;     // from its middle to the pixel's place on the ground
};

// width: of a pixel, in cells.
ClutterHit clutter_hit(ClutterRay c, ClutterThing thing, vec3 up, float width) {
    // From its middle, on the ground and in a space where it is round.
    vec2 off = c.at - thing.foot;
    vec3 level = vec3(off, -dot(off, up.xy) / up.z);
    vec3 o = level + (abs(c.along) * abs(c.rise) / thing.tall) * up, r = c.ray + (c.rise / thing.tall) * up;
    float inverse2 = 1.0 / dot(r, r), b = dot(o, r);
    vec3 nearest = o - (b * inverse2) * r;
    float aside = length(nearest), radius = thing.radius, turn = thing.turn;
    // Leaves: waves around the plant make its outline ragged.
    vec3 edge = nearest / max(aside, 1e-4);
    float wave = clutter_wave(2.0 * (edge.x - edge.y) + 1.5 * edge.z + turn);
    float ragged = thing.leaves ? 0.16 * wave + 0.12 * clutter_wave(4.9 * (edge.x - edge.y) + 3.7 * edge.z + turn)
        : 0.05 * wave;
    float half_chord = sqrt(max(radius * radius - aside * aside, 0.0) * inverse2);
    float blur = c.seeing ? width : 0.04 + 0.1 * c.along;
    // To the eye: the near side, above the ground. To the sun: the far side.
    float hit = b * inverse2 + (c.seeing ? half_chord : -half_chord);
    float surface = c.seeing ? c.along + hit : -hit;
    float cover = thing.there * clamp(0.5 + (radius * (1.0 + ragged) - aside) / blur, 0.0, 1.0) * step(0.0, surface);
    return ClutterHit(cover, (o - hit * r) / max(radius, aside), level);
}

// weight: of the pixel.
void add_seen(inout GroundClutter found, int kind, ClutterThing thing, vec3 normal, vec3 up, float weight) {
    float side = clamp(dot(normal, up), 0.0, 1.0), turn = thing.turn;
    // Clumps of leaves: two families of bent bands that cross.
    float bend = clutter_wave(1.9 * normal.z - 1.3 * normal.x + turn);
    float inner = clutter_wave(2.3 * normal.x + 1.7 * normal.z + 0.45 * bend + turn)
        * clutter_wave(2.6 * normal.y - 1.2 * normal.z + 0.35 * bend + 2.0 * turn);
    vec3 faces = vec3(clutter_wave(0.6 * normal.y + turn), clutter_wave(0.7 * normal.z + 2.0 * turn),
        clutter_wave(0.5 * normal.x + 3.0 * turn));
    found.tint += weight * thing.tint;
    found.plant += thing.leaves ? weight : 0.0;
    found.bush += thing.leaves && kind >= 2 ? weight : 0.0;
    found.light += weight * (thing.leaves ? mix(0.6, 1.15, side) * (1.0 + 0.4 * inner) : 1.0);
    // Stones have faces.
    found.normal += weight
        * (thing.leaves ? mix(normal, up, CLUTTER[kind].from_above) : normalize(normal + 0.4 * faces));
}

// The view of the pixel's ground, in the lattice's axes.
struct ClutterView {
    vec3 up, to_eye, to_sun;       // the latter two along the ground
    float eye_rise, sun_rise;      // and up
    float across, strength;        // metres that a pixel spans; 0..1
};

// All things of a kind on the way to the eye, then of their shadows. left: of the pixel, for what lies behind. start,
// first: of the pixel's ground, in a cell of the lattice and that cell. plants, stony: shares of cells.
void add_kind(
    inout GroundClutter found, inout float left, int kind, ClutterView v, vec2 start, ivec2 first, ClutterBeach strand,
    float plants, float stony
) {
    ClutterKind of = CLUTTER[kind];
    float size = NESTED_BASE_M * exp2(float(of.octave)), width = v.across / size;
    float here = clamp(2.0 - 2.0 * v.across / of.span_m, 0.0, 1.0) * v.strength;
    float top = max(of.plant_to * of.plant_tall, of.stone_to * of.stone_tall);
    // From where the ray comes in under the highest things to the ground, then from there towards the sun.
    float along = min(top / max(v.eye_rise, 1e-3), CLUTTER_REACH), end = 0.0;
    vec3 ray = -v.to_eye;
    vec2 at = start - along * ray.xy, over = floor(at);
    ClutterRay r = ClutterRay(ray, -v.eye_rise, along, at - over, over - start + 0.25, first + ivec2(over), true);
    int i = 0;
    do {
        ClutterThing thing = clutter_thing(kind, r.column, r.corner, size, strand, here, plants, stony);
        ClutterHit hit = clutter_hit(r, thing, v.up, width);
        if (r.seeing) {
            float weight = left * hit.cover;
            left -= weight;
            add_seen(found, kind, thing, hit.normal, v.up, weight);
        } else {
            found.sun *= 1.0 - of.shade * hit.cover;
            found.sky *= i == 0
                ? 1.0 - 0.55 * thing.there * clamp(1.0 - 1.6 * (length(hit.level) / thing.radius - 1.0), 0.0, 1.0)
                : 1.0;
        }
        next_cell(r);
        ++i;
        if (r.seeing && (r.along < 0.0 || left < 0.05)) {
            i = left < 0.05 ? CLUTTER_MOST : 0;
            end = min(top / max(v.sun_rise, 1e-3), 2.0);
            r = ClutterRay(v.to_sun, v.sun_rise, 0.0, start, 0.25 - start, first, false);
        } else if (!r.seeing && r.along > end) {
            i = CLUTTER_MOST;
        }
    } while (i < CLUTTER_MOST);
}

#ifdef GROUND_COVER
#include "terrain/grass.glsl"
#endif

// eye, sun: unit vectors, seen from ground whose normal is the zenith. across: what a pixel spans at right angles to
// the view, metres. stony: share of cells that hold a stone off the beach.
// above_sea: height of the pixel's ground, beach_m: of the beach there, metres; gradient: its rise around, in
// metres per metre.
GroundClutter ground_clutter(
    vec3 point, vec3 D, vec3 zenith, vec3 eye, vec3 sun, float across, float stony, Growth growth, float above_sea,
    float beach_m, vec3 gradient
) {
    GroundClutter found = GroundClutter(0.0, 0.0, 0.0, 0.0, 0.0, vec3(0.0), 1.0, 1.0, vec3(0.0), 0.0, 0.0);
    vec3 up = clutter_axes(zenith, zenith), to_eye = clutter_axes(eye, zenith), to_sun = clutter_axes(sun, zenith);
    float eye_rise = dot(to_eye, up), sun_rise = dot(to_sun, up), strength = terrain_material_block.clutter;
    ClutterView v = ClutterView(up, to_eye - eye_rise * up, to_sun - sun_rise * up, eye_rise, sun_rise, across,
        strength);
    ClutterBeach strand = clutter_beach(up, clutter_axes(gradient, zenith), above_sea, beach_m);
    float left = 1.0;   // of the pixel, for what lies behind
#ifdef GROUND_COVER
    // A loop of no turns costs a software GPU nothing.
    int grassy = across < GRASS[0].span_m ? 0 : GRASS_KINDS;
    Flower flower = Flower(0.0, vec2(0.0), 0.0, vec2(0.0));
    float grass = growth.tufts * cover_map.grass;
    GrassView seen = grass_view(v, point, zenith, grass, cover_map.flowers * cover_map.grass * growth.flowers);
    while (grassy < GRASS_KINDS) {
        ivec3 lattice;
        vec3 fraction;
        float frequency;
        nested_place(terrain_material_block.anchor.cell, terrain_material_block.anchor.fraction, D,
            GRASS[grassy].octave, lattice, fraction, frequency);
        add_grass(found, left, flower, grassy, v, seen, clutter_axes(fraction, zenith).xy,
            clutter_axes(lattice, zenith).xy, strand);
        ++grassy;
    }
    add_flower(found, left, flower, v, seen.along, seen.rise);
    growth = Growth(0.0, 0.0, 0.0, 0.0, 0.0, 0.0);   // bushes are solids, as trees are
#endif
    // From the finest that shows.
    int kind = 0;
    for (int k = 0; k < CLUTTER.length(); ++k) kind += across < CLUTTER[k].span_m && strength > 0.0 ? 0 : 1;
    if (kind < CLUTTER.length()) do {
        float plants = kind == 0 ? growth.tufts : kind == 1 ? growth.tussocks : kind == 2 ? growth.shrubs
            : growth.trees;
        ivec3 lattice;
        vec3 fraction;
        float frequency;
        nested_place(terrain_material_block.anchor.cell, terrain_material_block.anchor.fraction, D,
            CLUTTER[kind].octave, lattice, fraction, frequency);
        add_kind(found, left, kind, v, clutter_axes(fraction, zenith).xy, clutter_axes(lattice, zenith).xy, strand,
            plants, stony);
    } while (++kind < CLUTTER.length());
    found.cover = 1.0 - left;
    float whole = 1.0 / max(found.cover, 1e-3);
    found.tint *= whole;
    found.plant *= whole;
    found.bush *= whole;
    found.light *= whole;
    found.bloom *= whole;
    found.bloomed *= whole;
    found.dry *= whole;
    found.normal = clutter_planet(found.normal, zenith);
    return found;
}
