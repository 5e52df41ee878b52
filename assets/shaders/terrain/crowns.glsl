// Crowns of a forest beyond the trees that stand as solids: in each cell of a lattice a few, which end at the cell's
// walls, so that no neighbour has to be asked. The pixel's ray is followed from where it comes in under the tallest
// tree through COVER_CROWNS cells, then from what it has met through one or two towards the sun; what it has not met by
// then is the mean of many. They grow where solids shrink.
#include "common/nested_noise.glsl"
#include "terrain/lattice_axes.glsl"

const float CROWNS_FROM = 0.62 * float(GROUND_COVER);   // metres
const float CROWN_SPAN = 0.5;               // of a crown's radius that a pixel spans where they begin to fade
const vec2 CROWN_LOW = vec2(0.45, 1.40);    // of the sun that a crown gets low among others, and at the top
const vec2 CROWN_OPEN = vec2(0.5, 1.2);     // and of the sky
const float CROWN_LIT = 0.2;                // light on the side of a crown that the sun doesn't see
const float CROWN_CLUMPS = 0.35;            // how much light its bulges have more than its folds
// Fitted, so that a forest is as light as its own colour (planetfall bench cover.far): the mean of all this, for how
// high the eye is, and the cosine of its angle with the sun.
const vec3 CROWN_MEAN = vec3(0.78, 0.13, 0.30);
const vec2 CROWN_DARK = vec2(0.97, 0.65);    // of the sun that a crown takes from the ground, and from another
const vec2 CROWN_FEET = vec2(0.04, 0.96);   // of a cell
const vec2 CONIFER = vec2(0.69, 1.3);       // its width and height over a broadleaf's
const float CROWN_FLAT = 0.85;              // of a tree's height, where the flattest rays come in
const vec2 CROWN_HALF = vec2(0.36, 0.50);   // half a crown's height over the tree's: of broadleaves, of conifers
const float SUN_CELLS = 2.0;                // on a ray to the sun

struct Crowns {
    float here;    // 0..1: how much they show
    float left;    // of the pixel, where the ray has met the ground
    float sun;     // 0..1: what crowns leave of the sun to that
    float met;     // of the pixel, where it has met a crown
    float light;   // met times the sun that a crown's place gets, over the mean's
    float sky;     // and the sky
    float tint;    // met times -1..1
};

// share: of places that have one; conifer: of those; wide_m: a crown's mean radius; in_sun: area of crowns across the
// sun's light, over the ground's.
Crowns crowns_seen(Spot s, float share, float conifer, float wide_m, float tall_m, float in_sun) {
    int octave = int(cover_map.octave);
    float size = NESTED_BASE_M * exp2(float(octave)), width = s.across_m / size, wide = wide_m / size;
    Crowns found = Crowns(clamp(2.0 - s.across_m / (CROWN_SPAN * wide_m), 0.0, 1.0)
        * step(0.01, share) * step(CROWNS_FROM, s.distance_m), 1.0, 1.0, 0.0, 0.0, 0.0, 0.0);
    if (found.here <= 0.0) return found;
    vec3 up = clutter_axes(s.zenith, s.zenith), eye = clutter_axes(levelled(s.view, s.coarse, s.zenith), s.zenith);
    vec3 sun = frame.sun_direction + max(0.05 - dot(frame.sun_direction, s.zenith), 0.0) * s.zenith;
    sun = clutter_axes(levelled(normalize(sun), s.coarse, s.zenith), s.zenith);
    float rise = dot(eye, up), tall = tall_m / size, top = tall * CONIFER.y;
    ivec3 lattice;
    vec3 fraction;
    float frequency;
    nested_place(terrain_material_block.anchor.cell, terrain_material_block.anchor.fraction, s.D, octave, lattice,
        fraction, frequency);
    // In cells. ray: along the ground; climbs: and up, for each cell along it.
    vec3 ray = rise * up - eye;
    // Flat rays come in lower: they would be all cells above the crowns.
    float height = clamp(float(COVER_CROWNS) * rise, CROWN_FLAT * tall, top), climbs = -rise;
    float turns = float(COVER_CROWNS);
    vec2 at = clutter_axes(fraction, s.zenith).xy - (height / rise) * ray.xy, over = floor(at);
    ivec2 column = clutter_axes(lattice, s.zenith).xy + ivec2(over);
    at -= over;
    bool seeing = true;
    float clumps = CROWN_CLUMPS * clamp(1.5 - 3.0 * width / wide, 0.0, 1.0);
    // Of what is seen of crowns the mean faces between the eye and up.
    float facing = 0.7 * dot(normalize(up + eye), sun);
    float mean_lit = mix(0.5 * (facing + sqrt(facing * facing + 0.25)), 1.0, CROWN_LIT)
        * (dot(CROWN_MEAN, vec3(1.0, rise, dot(eye, sun))) - 0.10 * conifer);
    while (turns > 0.0) {
        uvec2 seed = uvec2(column + 71) * 1664525u + 1013904223u;
        ivec3 bits = lattice_hash(seed.x, seed.y, 2654435769u);
        vec3 one = vec3(bits & 0xfff) * (1.0 / 4095.0), two = vec3((bits >> 12) & 0xfff) * (1.0 / 4095.0);
        float away = (s.distance_m - (seeing ? height / rise * size : 0.0)) * (1.0 / float(GROUND_COVER));
        vec2 wall = (step(0.0, ray.xy) - at) / (ray.xy + vec2(1e-9));
        float leaves = max(min(wall.x, wall.y), 0.0) + 1e-4;
        leaves = seeing ? min(leaves, height / rise + 1e-4) : leaves;
        float nearest_t = leaves, cover = 0.0, hue_met = 0.0;
        vec3 normal = up;
        for (int k = 0; k < int(cover_map.in_cell); ++k) {
            vec2 foot = mix(vec2(CROWN_FEET.x), vec2(CROWN_FEET.y),
                fract(one.xy + float(k) * vec2(0.7548777, 0.5698403)));
            float chance = fract(one.z + float(k) * 0.6180340), age = fract(two.x + float(k) * 0.4142136);
            bool cone = fract(two.y + float(k) * 0.7320508) < conifer;
            float hue = fract(two.z + float(k) * 0.3247180);
            float grown = clamp((away - 0.62 - 0.28 * hue) * 10.0, 0.0, 1.0) * step(chance, share);
            float high = tall * (0.62 + 0.5 * age) * (cone ? CONIFER.y : 1.0) * grown;
            float semi = high * (cone ? CROWN_HALF.y : CROWN_HALF.x) + 1e-3;
            float radius = wide * (0.70 + 0.40 * age) * (cone ? CONIFER.x : 1.0) * grown + 1e-4;
            vec2 off = at - foot;
            // In a space where it is round.
            float squash = radius / semi;
            vec3 o = vec3(off, -dot(off, up.xy) / up.z) + ((height - high + semi) * squash) * up;
            vec3 d = ray + (climbs * squash) * up;
            float inverse2 = 1.0 / dot(d, d), b = dot(o, d) * inverse2;
            vec3 nearest = o - b * d;
            float aside = length(nearest);
            float ragged = 1.0
                + 0.10 * clutter_wave(hue + (1.7 * nearest.x - 1.3 * nearest.y + 1.1 * nearest.z) / radius);
            float half_chord = sqrt(max(radius * radius - aside * aside, 0.0) * inverse2);
            float enters = max(-b - half_chord, 0.0);
            float covers = clamp(0.5 + (radius * ragged - aside) / width, 0.0, 1.0) * step(0.01, grown);
            if (enters < nearest_t && half_chord > b && covers > 0.0) {
                nearest_t = enters;
                cover = covers;
                hue_met = hue;
                vec3 round = (o + enters * d) / radius;
                normal = normalize(round + (squash - 1.0) * dot(round, up) * up + 0.15 * up);
            }
        }
        float low = clamp((height + nearest_t * climbs) / tall, 0.0, 1.0);
        float weight = seeing ? found.left * cover : 0.0;
        found.left -= weight;
        found.met += weight;
        float clump = clumps * clutter_wave(dot(normal, vec3(1.9, -1.3, 2.1)) + 3.0 * hue_met);
        found.light += weight * mix(max(dot(normal, sun), 0.0), 1.0, CROWN_LIT) / mean_lit
            * mix(CROWN_LOW.x, CROWN_LOW.y, low) * (1.0 + clump);
        found.sky += weight * mix(CROWN_OPEN.x, CROWN_OPEN.y, low) * (0.8 + 0.25 * dot(normal, up));
        found.tint += weight * (2.0 * hue_met - 1.0);
        found.sun *= seeing ? 1.0 : 1.0 - cover * (found.left < 0.05 ? CROWN_DARK.y : CROWN_DARK.x);
        turns -= 1.0;
        bool ends = seeing && found.left < 0.05;
        float step_t = ends ? max(nearest_t, 0.0) : leaves;
        at += step_t * ray.xy;
        height += step_t * climbs;
        if (ends) {
            // Off the crown that was met.
            at += 0.03 * normal.xy;
            height += 0.03 * dot(normal, up);
        }
        over = floor(at);
        column += ivec2(over);
        at -= over;
        if (ends || (seeing && height <= 0.0)) {
            seeing = false;
            turns = SUN_CELLS;
            climbs = dot(sun, up);
            ray = sun - climbs * up;
        }
        turns = !seeing && height > top ? 0.0 : turns;
    }
    // What a ray may meet beyond is the mean.
    float rest = exp(-in_sun * clamp(1.0 - height / tall, 0.0, 1.0));
    bool crown = found.left < 0.05;
    found.light *= crown ? found.sun : 1.0;
    found.sun *= seeing ? 1.0 : rest;
    // Others are met that were not tried.
    found.left *= seeing ? 0.0 : 1.0;
    return found;
}
