// Crowns of a forest beyond the trees that stand as solids: one in each cell of a lattice, wherever in it. The pixel's
// ray is followed from where it comes in under the tallest tree through COVER_CROWNS slabs of cells, then from what it
// has met through a few towards the sun; what it has not met by then is the mean of many. They grow where solids
// shrink.
#include "common/nested_noise.glsl"
#include "terrain/lattice_axes.glsl"

const float CROWN_SPAN = 0.5;               // of a crown's radius that a pixel spans where they begin to fade
const vec2 CROWN_LOW = vec2(0.45, 1.40);    // of the sun that a crown gets low among others, and at the top
const vec2 CROWN_OPEN = vec2(0.12, 1.42);   // and of the sky
const float CROWN_LIT = 0.2;                // light on the side of a crown that the sun doesn't see
const float CROWN_CLUMPS = 0.45;            // how much light its bulges have more than its folds
const vec2 CROWN_SKY = vec2(0.45, 0.60);    // of the sky: on its sides, and more where it faces up
// Fitted, so that a forest is as light as its own colour (planetfall bench cover.far): the mean of all this, for how
// high the eye is, and the cosine of its angle with the sun.
const vec3 CROWN_MEAN = vec3(0.78, 0.13, 0.30);
const vec2 CROWN_DARK = vec2(0.97, 0.65);    // of the sun that a crown takes from the ground, and from another
const vec2 CONIFER = vec2(0.69, 1.3);       // its width and height over a broadleaf's
const float CROWN_FLAT = 0.85;              // of a tree's height, where the flattest rays come in
const vec2 CROWN_HALF = vec2(0.36, 0.50);   // half a crown's height over the tree's: of broadleaves, of conifers
// Where trees differ (Cover.variety): radii and heights over the mean, of small ones, what they grow by, and what few
// giants have more; the widest, in cells: none reaches a cell that is not looked at.
const vec2 CROWN_SMALL = vec2(0.50, 0.50), CROWN_GROWS = vec2(0.86, 0.52), CROWN_GIANT = vec2(0.52, 0.24);
const float CROWN_WIDEST = 1.05;
const float CROWN_MISSING = 0.12;           // share of places where none stands, beside a giant
const vec2 CROWN_UNEVEN = vec2(0.10, 0.17);  // how ragged outlines are where trees are equal, and differ
const float CROWN_LUMPY = 0.9;              // how far bulges turn a crown's sides
const float CROWN_MORE_LIT = 0.12;          // of the sun that broadleaves of many sizes get, over that of equal ones
const float WIDE_M = 160.0;                // the longest stretch of ground that is asked how it rises
const vec2 EDGE_SHARES = vec2(0.1, 0.5);   // of that in the picture, between which it comes to count
const float SUN_SLABS = 3.0;               // on a ray to the sun

struct Crowns {
    float here;    // 0..1: how much they show
    float left;    // of the pixel, where the ray has met the ground
    float sun;     // 0..1: what crowns leave of the sun to that
    float met;     // of the pixel, where it has met a crown
    float light;   // met times the sun that a crown's place gets, over the mean's
    float sky;     // and the sky
    float tint;    // met times -1..1
    float hue;     // the same, of its species
    float up;      // met times how far that faces up, 0..1
};

// The ground in the picture near a place that is given from the camera, xyz from s.point; w: 1, or 0 where something
// else is seen there.
vec4 ground_beside(Spot s, vec3 place) {
    vec4 clip = clip_position(place);
    vec2 ndc = clip.xy / max(clip.w, 1e-3);
    ivec2 pixel = ivec2(floor((0.5 + 0.5 * ndc) / frame.texel_size));
    vec2 inside = step(abs(ndc), vec2(0.999));
    bool ground = inside.x * inside.y * clip.w > 0.0 && texel_at(u_surface, pixel).r == SURFACE_TERRAIN;
    ndc = ndc_of_pixel(vec2(pixel) + 0.5);
    float depth = ground ? texel_at(u_depth, pixel).r : 1.0;
    return vec4(position_from_depth(ndc, max(depth, 1e-9)) - s.point, ground && depth > 0.0 ? 1.0 : 0.0);
}

// How much of the way from s.point by `way` lies in the picture, 0..1.
float in_picture(Spot s, vec3 way) {
    vec4 here = clip_position(s.point), there = clip_position(s.point + way);
    // From the left, right, lower and upper edge.
    vec4 before = 0.99 * here.w + vec4(here.x, -here.x, here.y, -here.y);
    vec4 after = 0.99 * there.w + vec4(there.x, -there.x, there.y, -there.y);
    vec4 share = mix(vec4(1.0), before / max(before - after, vec4(1e-6)), lessThan(after, vec4(0.0)));
    return clamp(min(min(share.x, share.y), min(share.z, share.w)), 0.0, 1.0);
}

// The plane that the ground has over the stretch in which a ray is followed, from other pixels: its normal, and w how
// high above it the pixel's own place is. With the normal of each pixel rays that lie side by side would meet the same
// crown elsewhere, and it would be seen smeared. Towards the picture's edges the stretch becomes shorter and gives way
// to that normal.
vec4 wide_ground(Spot s, float tall_m) {
    vec3 ahead = normalize(s.view - dot(s.view, s.zenith) * s.zenith), aside = cross(s.zenith, ahead);
    vec3 rises = s.zenith - s.coarse / max(dot(s.coarse, s.zenith), 0.05);
    float reach_m = clamp(tall_m / max(dot(s.coarse, s.view), 0.06), 2.0 * tall_m, WIDE_M), lift_m = 0.0;
    vec2 slope = vec2(dot(rises, ahead), dot(rises, aside));
    vec3 to = reach_m * (ahead + clamp(slope.x, -0.5, 0.5) * s.zenith);
    float share = in_picture(s, to), long_m = share * reach_m, known = ramp(EDGE_SHARES.x, EDGE_SHARES.y, share);
    vec4 half_way = ground_beside(s, s.point + 0.5 * share * to), nearer = ground_beside(s, s.point + share * to);
    vec3 x = vec3(0.0, dot(half_way.xyz, ahead), dot(nearer.xyz, ahead));
    vec3 y = vec3(0.0, dot(half_way.xyz, s.zenith), dot(nearer.xyz, s.zenith));
    if (nearer.w * half_way.w * x.y > 0.1 * long_m && x.z > x.y + 0.1 * long_m && x.z < 3.0 * long_m) {
        // The line of least squares through three places.
        float mean_x = (x.y + x.z) / 3.0, mean_y = (y.y + y.z) / 3.0;
        vec3 dx = x - mean_x;
        float found = dot(dx, y) / dot(dx, dx);
        lift_m = known * (found * mean_x - mean_y);
        slope.x = mix(slope.x, found, known);
    }
    to = reach_m * (aside + clamp(slope.y, -0.5, 0.5) * s.zenith);
    share = in_picture(s, to);
    nearer = ground_beside(s, s.point + share * to);
    vec2 moved = vec2(dot(nearer.xyz, ahead), dot(nearer.xyz, aside));
    if (nearer.w * moved.y > 0.3 * share * reach_m && abs(moved.x) < 3.0 * share * reach_m)
        slope.y = mix(slope.y, (dot(nearer.xyz, s.zenith) + lift_m - slope.x * moved.x) / moved.y,
            ramp(EDGE_SHARES.x, EDGE_SHARES.y, share));
    slope = clamp(slope, -2.0, 2.0);
    return vec4(normalize(s.zenith - slope.x * ahead - slope.y * aside), clamp(lift_m, -0.5 * tall_m, 0.5 * tall_m));
}

// share: of places that have one; conifer: of those; wide_m: a crown's mean radius; in_sun: area of crowns across the
// sun's light, over the ground's.
Crowns crowns_seen(Spot s, float share, float conifer, float wide_m, float tall_m, float in_sun) {
    int octave = int(cover_map.octave);
    float size = NESTED_BASE_M * exp2(float(octave)), width = s.across_m / size, wide = wide_m / size;
    Crowns found = Crowns(clamp(2.0 - s.across_m / (CROWN_SPAN * wide_m), 0.0, 1.0)
        * step(0.01, share) * step(CROWNS_FROM, s.distance_m), 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    if (found.here <= 0.0) return found;
    vec4 plane = wide_ground(s, tall_m);
    vec3 up = clutter_axes(s.zenith, s.zenith), eye = clutter_axes(levelled(s.view, plane.xyz, s.zenith), s.zenith);
    vec3 sun = frame.sun_direction + max(0.05 - dot(frame.sun_direction, s.zenith), 0.0) * s.zenith;
    sun = clutter_axes(levelled(normalize(sun), plane.xyz, s.zenith), s.zenith);
    float rise = dot(eye, up), lift = plane.w / size, tall = tall_m / size, top = tall * CONIFER.y;
    ivec3 lattice;
    vec3 fraction;
    float frequency;
    nested_place(terrain_material_block.anchor.cell, terrain_material_block.anchor.fraction, s.D, octave, lattice,
        fraction, frequency);
    // In cells. ray: along the ground; climbs: and up, for each cell along it.
    vec3 ray = rise * up - eye;
    // Flat rays come in lower: they would be all cells above the crowns.
    float height = clamp(float(COVER_CROWNS) * rise + lift, CROWN_FLAT * tall, top), climbs = -rise;
    float turns = float(COVER_CROWNS);
    vec2 at = clutter_axes(fraction, s.zenith).xy - ((height - lift) / rise) * ray.xy, over = floor(at);
    ivec2 column = clutter_axes(lattice, s.zenith).xy + ivec2(over);
    at -= over;
    bool seeing = true;
    float uneven = mix(CROWN_UNEVEN.x, CROWN_UNEVEN.y, cover_map.variety);
    float standing = share * (1.0 - CROWN_MISSING * cover_map.variety);
    float clumps = CROWN_CLUMPS * clamp(1.5 - 3.0 * width / wide, 0.0, 1.0);
    // Of what is seen of crowns the mean faces between the eye and up.
    float facing = 0.7 * dot(normalize(up + eye), sun);
    float mean_lit = mix(0.5 * (facing + sqrt(facing * facing + 0.25)), 1.0, CROWN_LIT)
        * (dot(CROWN_MEAN, vec3(1.0, rise, dot(eye, sun))) - 0.10 * conifer)
        * (1.0 + CROWN_MORE_LIT * (1.0 - conifer) * cover_map.variety);
    while (turns > 0.0) {
        // A slab of cells across the axis that the ray follows best, and of those the three that lie around it: no
        // crown of another reaches it.
        vec2 along = abs(ray.x) > abs(ray.y) ? vec2(1.0, 0.0) : vec2(0.0, 1.0), aside = along.yx;
        float slab = dot(step(0.0, ray.xy) - at, along) / (dot(ray.xy, along) + 1e-9) + 1e-4;
        vec2 beside = floor(dot(at + 0.5 * slab * ray.xy, aside)) * aside;
        float away = (s.distance_m - (seeing ? (height - lift) / rise * size : 0.0)) * (1.0 / float(GROUND_COVER));
        float ground = seeing ? (height - lift) / rise + 1e-4 : 1e9, nearest_t = ground, cover = 0.0, hue_met = 0.0;
        vec3 normal = up;
        for (int k = -1; k <= 1; ++k) {
            vec2 cell = beside + float(k) * aside;
            uvec2 seed = uvec2(column + ivec2(cell) + 71) * 1664525u + 1013904223u;
            ivec3 bits = lattice_hash(seed.x, seed.y, 2654435769u);
            vec3 one = vec3(bits & 0xfff) * (1.0 / 4095.0), two = vec3((bits >> 12) & 0xfff) * (1.0 / 4095.0);
            float age = two.x, hue = two.z, giant = age * age * age;
            giant *= cover_map.variety * giant;
            // Giants stand nearer to the middle of theirs.
            vec2 foot = cell + mix(one.xy, vec2(0.5), 0.5 * giant);
            bool cone = two.y < conifer;
            float grown = clamp((away - 0.62 - 0.28 * hue) * 10.0, 0.0, 1.0) * step(one.z, standing);
            vec2 sizes = mix(vec2(0.70, 0.62) + vec2(0.40, 0.50) * age,
                CROWN_SMALL + CROWN_GROWS * age + CROWN_GIANT * giant, cover_map.variety);
            float high = tall * sizes.y * (cone ? CONIFER.y : 1.0) * grown;
            float semi = high * (cone ? CROWN_HALF.y : CROWN_HALF.x) + 1e-3;
            float radius = min(wide * sizes.x, CROWN_WIDEST) * (cone ? CONIFER.x : 1.0) * grown + 1e-4;
            vec2 off = at - foot;
            // In a space where it is round.
            float squash = radius / semi;
            vec3 o = vec3(off, -dot(off, up.xy) / up.z) + ((height - high + semi) * squash) * up;
            vec3 d = ray + (climbs * squash) * up;
            float inverse2 = 1.0 / dot(d, d), b = dot(o, d) * inverse2;
            vec3 nearest = o - b * d;
            float from_axis = length(nearest);
            float ragged = 1.0
                + uneven * clutter_wave(hue + (1.7 * nearest.x - 1.3 * nearest.y + 1.1 * nearest.z) / radius);
            float half_chord = sqrt(max(radius * radius - from_axis * from_axis, 0.0) * inverse2);
            float enters = seeing ? -b - half_chord : max(-b - half_chord, 0.0);
            float covers = clamp(0.5 + (radius * ragged - from_axis) / width, 0.0, 1.0) * step(0.01, grown);
            // Those that it has passed take nothing from the sun.
            if (enters < nearest_t && (seeing || half_chord > b) && covers > 0.0) {
                nearest_t = enters;
                cover = covers;
                hue_met = hue;
                vec3 ball = (o + enters * d) / radius;
                normal = normalize(ball + (squash - 1.0) * dot(ball, up) * up + 0.15 * up);
            }
        }
        float low = clamp((height + min(nearest_t, slab) * climbs) / tall, 0.0, 1.0);
        float weight = seeing ? found.left * cover : 0.0;
        found.left -= weight;
        found.met += weight;
        // Products of waves along three ways: lumps, where one wave would be stripes.
        vec3 lumps = vec3(clutter_wave(dot(normal, vec3(1.3, -0.9, 0.7)) + 3.0 * hue_met),
            clutter_wave(dot(normal, vec3(-0.6, 1.2, 1.1)) + 5.0 * hue_met),
            clutter_wave(dot(normal, vec3(0.9, 0.8, -1.3)) + 7.0 * hue_met));
        float clump = clumps * dot(lumps, lumps.yzx);
        vec3 facing_as = normalize(normal + (CROWN_LUMPY * cover_map.variety * clumps) * lumps);
        found.light += weight * mix(max(dot(facing_as, sun), 0.0), 1.0, CROWN_LIT) / mean_lit
            * mix(CROWN_LOW.x, CROWN_LOW.y, low) * (1.0 + clump);
        found.sky += weight * mix(CROWN_OPEN.x, CROWN_OPEN.y, low)
            * dot(CROWN_SKY, vec2(1.0, max(dot(facing_as, up), 0.0))) * (1.0 + clump);
        found.up += weight * max(dot(normal, up), 0.0);
        found.tint += weight * (2.0 * hue_met - 1.0);
        float species = 2.0 * fract(7.0 * hue_met) - 1.0;
        found.hue += (SPECIES_HUE * weight) * species * species * species;
        found.sun *= seeing ? 1.0 : 1.0 - cover * (found.left < 0.05 ? CROWN_DARK.y : CROWN_DARK.x);
        turns -= 1.0;
        bool ends = seeing && found.left < 0.05;
        float step_t = ends ? nearest_t : min(slab, ground);
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
        if (ends || (seeing && height <= lift + 1e-4)) {
            seeing = false;
            turns = SUN_SLABS;
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
