// What stands on the ground near the camera: pebbles and tufts of grass, stones and tussocks, boulders and shrubs, at
// most one in a cell of a square lattice, and inside it, so that no neighbour has to be asked. The pixel's ray is
// followed from the ground back towards the camera through the cells that it crosses, so things have sides, hide one
// another, and throw shadows; the ground's own depth stays. Heights count from the ground as if it were level, so
// nothing floats. Sizes are the world's. A kind goes where pixels grow as large as its things, and from there on it
// costs nothing.
#include "terrain/material.glsl"
#include "common/nested_noise.glsl"
#include "common/surfaces.glsl"

struct GroundClutter {
    float cover;   // 0..1: share of the pixel with one in front
    float tint;    // -1..1, the same all over one
    float plant;   // 0: stone, 1: plant
    float bush;    // 1: a plant of the largest kind
    float light;   // 0..1: what neighbouring leaves leave to a plant, 1 at its top
    vec3 normal;   // cover times that of its surface, where the ground's is the zenith
    float sun;     // 0..1: what the others leave of the sun to the ground
    float sky;     // 0..1: the same of the sky
};

const int CLUTTER_KINDS = 4, CLUTTER_MOST = 6;   // the latter: cells on a ray
const float CLUTTER_REACH = 3.0;   // how far a ray is followed, in cells
// What a pixel spans where a kind is gone; the largest is that of near tiles.
const float CLUTTER_SPAN_M[4] = float[4](0.03, 0.1, 0.5, NEAR_ACROSS_M);
const int CLUTTER_STEP[4] = int[4](1, 3, 6, 7);   // cells of 0.125, 0.5, 4 and 8 m
// Radii in cells: of plants from, to; of stones from, to.
const vec4 CLUTTER_RADIUS[4] = vec4[4](
    vec4(0.12, 0.34, 0.08, 0.30), vec4(0.08, 0.30, 0.08, 0.28), vec4(0.06, 0.20, 0.03, 0.11),
        vec4(0.10, 0.40, 0.01, 0.05));
// Height over radius: of plants, of stones; share of the sun that is lost behind a plant; how much a plant is lit from
// above.
const vec4 CLUTTER_SHAPE[4] = vec4[4](
    vec4(2.2, 0.7, 0.5, 0.6), vec4(1.1, 0.65, 0.7, 0.6), vec4(0.85, 0.8, 0.85, 0.3), vec4(1.25, 0.8, 0.85, 0.2));

// The lattice's axes: the two of the planet that the ground follows best, and the third.
vec3 clutter_axes(vec3 v, vec3 zenith) {
    vec3 z = abs(zenith);
    return z.x >= max(z.y, z.z) ? v.yzx : z.y >= z.z ? v.zxy : v;
}

ivec3 clutter_axes(ivec3 v, vec3 zenith) {
    vec3 z = abs(zenith);
    return z.x >= max(z.y, z.z) ? v.yzx : z.y >= z.z ? v.zxy : v;
}

vec3 clutter_planet(vec3 v, vec3 zenith) {
    vec3 z = abs(zenith);
    return z.x >= max(z.y, z.z) ? v.zxy : z.y >= z.z ? v.yzx : v;
}

float clutter_wave(float x) {
    return abs(4.0 * fract(x) - 2.0) - 1.0;
}

// eye, sun: unit vectors, seen from ground whose normal is the zenith. across: what a pixel spans at right angles to
// the view, metres. stony: share of cells that hold a stone, leafy: of each size that hold a plant, both off the beach.
// above_sea: height of the pixel's ground, metres; gradient: its rise around, in metres per metre.
GroundClutter ground_clutter(
    vec3 D, vec3 zenith, vec3 eye, vec3 sun, float across, float stony, vec4 leafy, float above_sea, vec3 gradient
) {
    GroundClutter found = GroundClutter(0.0, 0.0, 0.0, 0.0, 0.0, vec3(0.0), 1.0, 1.0);
    vec3 up = clutter_axes(zenith, zenith), to_eye = clutter_axes(eye, zenith), to_sun = clutter_axes(sun, zenith);
    float eye_rise = dot(to_eye, up), sun_rise = dot(to_sun, up);
    to_eye -= eye_rise * up;
    to_sun -= sun_rise * up;
    // What stands at a place hangs on the ground there, not on the ground that a ray comes to behind it. So how much of
    // a beach it is follows from the height at the foot, and has none of the noise in material.glsl, which would cut
    // through things at its edge.
    vec3 slope = clutter_axes(gradient, zenith);
    float per_m = -2.5 / (terrain_material_block.limits.z + 1e-3), strand = 2.5 + per_m * above_sea;
    slope.xy = per_m * (slope.xy - slope.z / up.z * up.xy);
    float strength = terrain_material_block.look.w;
    // From the finest that shows.
    int kind = 0;
    for (int k = 0; k < CLUTTER_KINDS; ++k) kind += across < CLUTTER_SPAN_M[k] && strength > 0.0 ? 0 : 1;
    float left = 1.0;   // of the pixel, for what lies behind
    if (kind < CLUTTER_KINDS) do {
        float size = NESTED_BASE_M * exp2(float(CLUTTER_STEP[kind])), width = across / size;
        vec4 radii = CLUTTER_RADIUS[kind], shape = CLUTTER_SHAPE[kind];
        float here = clamp(2.0 - 2.0 * across / CLUTTER_SPAN_M[kind], 0.0, 1.0) * strength, share = leafy[kind];
        ivec3 lattice;
        vec3 fraction;
        float frequency;
        nested_place(terrain_material_block.anchor_cell.xyz, terrain_material_block.anchor_fraction.xyz, D,
            CLUTTER_STEP[kind], lattice,
            fraction, frequency);
        ivec2 first = clutter_axes(lattice, zenith).xy;
        vec2 start = clutter_axes(fraction, zenith).xy;
        float top = max(radii.y * shape.x, radii.w * shape.y);
        // From where the ray comes in under the highest things to the ground, then from there towards the sun.
        float along = min(top / max(eye_rise, 1e-3), CLUTTER_REACH), end = 0.0;
        vec3 ray = -to_eye;
        float rise = -eye_rise;
        // of the cell, from the pixel
        vec2 at = start - along * ray.xy, over = floor(at), corner = over - start + 0.25;
        ivec2 column = first + ivec2(over);
        at -= over;
        bool seeing = true;
        int i = 0;
        do {
            uvec2 seed = uvec2(column + 71) * 1664525u + 1013904223u;
            ivec3 bits = lattice_hash(seed.x, seed.y, uint(kind) * 747796405u + 2891336453u);
            vec3 place = vec3(bits & 0xfff) * (1.0 / 4095.0), more = vec3((bits >> 12) & 0xfff) * (1.0 / 4095.0);
            // Plants stand in groups.
            vec2 group = vec2(column & 4095) * (1.0 / 4096.0);
            float dense = clutter_wave(241.0 * group.x + 0.4 * clutter_wave(151.0 * group.y))
                + clutter_wave(199.0 * group.y + 0.4 * clutter_wave(113.0 * group.x));
            float beach = clamp(strand + dot(slope.xy, size * (corner + 0.5 * place.xy)), 0.0, 1.0);
            bool leaves = more.y < (share - BEACH_TAKES.y * share * beach)
                * clamp(0.8 + 0.5 * dense, 0.1, 1.0);
            float radius = leaves ? mix(radii.x, radii.y, more.x * more.x)
                : mix(radii.z, radii.w, more.x * more.x * more.x);
            float tall = leaves ? shape.x : shape.y;
            float stones = (stony - BEACH_TAKES.x * stony * beach) * clamp(0.7 - 0.5 * dense, 0.1, 1.0);
            float there = leaves || more.y > 1.0 - stones ? here : 0.0;
            // From its middle, on the ground and in a space where it is round.
            vec2 off = at - mix(vec2(radius), vec2(1.0 - radius), place.xy);
            vec3 level = vec3(off, -dot(off, up.xy) / up.z);
            vec3 o = level + (abs(along) * abs(rise) / tall) * up, r = ray + (rise / tall) * up;
            float inverse2 = 1.0 / dot(r, r), b = dot(o, r);
            vec3 nearest = o - (b * inverse2) * r;
            float aside = length(nearest);
            // Leaves: waves around the plant make its outline ragged.
            vec3 edge = nearest / max(aside, 1e-4);
            float turn = 6.0 * more.z, wave = clutter_wave(2.0 * (edge.x - edge.y) + 1.5 * edge.z + turn);
            float ragged = leaves ? 0.16 * wave + 0.12 * clutter_wave(4.9 * (edge.x - edge.y) + 3.7 * edge.z + turn)
                : 0.05 * wave;
            float half_chord = sqrt(max(radius * radius - aside * aside, 0.0) * inverse2);
            float blur = seeing ? width : 0.04 + 0.1 * along;
            // To the eye: the near side, above the ground. To the sun: the far side.
            float hit = b * inverse2 + (seeing ? half_chord : -half_chord);
            float surface = seeing ? along + hit : -hit;
            float cover = there * clamp(0.5 + (radius * (1.0 + ragged) - aside) / blur, 0.0, 1.0) * step(0.0, surface);
            if (seeing) {
                vec3 normal = (o - hit * r) / max(radius, aside);
                float weight = left * cover, side = clamp(dot(normal, up), 0.0, 1.0);
                // Clumps of leaves: two families of bent bands that cross.
                float bend = clutter_wave(1.9 * normal.z - 1.3 * normal.x + turn);
                float inner = clutter_wave(2.3 * normal.x + 1.7 * normal.z + 0.45 * bend + turn)
                    * clutter_wave(2.6 * normal.y - 1.2 * normal.z + 0.35 * bend + 2.0 * turn);
                vec3 faces = vec3(clutter_wave(0.6 * normal.y + turn), clutter_wave(0.7 * normal.z + 2.0 * turn),
                    clutter_wave(0.5 * normal.x + 3.0 * turn));
                left -= weight;
                found.tint += weight * (2.0 * place.z - 1.0);
                found.plant += leaves ? weight : 0.0;
                found.bush += leaves && kind >= 2 ? weight : 0.0;
                found.light += weight * (leaves ? mix(0.6, 1.15, side) * (1.0 + 0.4 * inner) : 1.0);
                // Stones have faces.
                found.normal += weight * (leaves ? mix(normal, up, shape.w) : normalize(normal + 0.4 * faces));
            } else {
                found.sun *= 1.0 - shape.z * cover;
                found.sky *= i == 0 ? 1.0 - 0.55 * there * clamp(1.0 - 1.6 * (length(level) / radius - 1.0), 0.0, 1.0)
                    : 1.0;
            }
            vec2 wall = (step(0.0, ray.xy) - at) / (ray.xy + vec2(1e-9));
            float t = max(min(wall.x, wall.y), 0.0) + 1e-4;
            along += seeing ? -t : t;
            at += t * ray.xy;
            over = floor(at);
            column += ivec2(over);
            corner += over;
            at -= over;
            ++i;
            if (seeing && (along < 0.0 || left < 0.05)) {
                seeing = false;
                i = left < 0.05 ? CLUTTER_MOST : 0;
                along = 0.0;
                end = min(top / max(sun_rise, 1e-3), 2.0);
                ray = to_sun;
                rise = sun_rise;
                at = start;
                corner = 0.25 - start;
                column = first;
            } else if (!seeing && along > end) {
                i = CLUTTER_MOST;
            }
        } while (i < CLUTTER_MOST);
    } while (++kind < CLUTTER_KINDS);
    found.cover = 1.0 - left;
    float whole = 1.0 / max(found.cover, 1e-3);
    found.tint *= whole;
    found.plant *= whole;
    found.bush *= whole;
    found.light *= whole;
    found.normal = clutter_planet(found.normal, zenith);
    return found;
}
