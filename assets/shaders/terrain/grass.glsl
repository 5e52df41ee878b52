// Grass and flowers near the camera: blades that stand in the cells of a square lattice, each from its foot to its tip
// inside one cell, so that no neighbour has to be asked. The pixel's ray is followed through the cells from the eye to
// the ground, and each blade covers as much of the pixel as it is wide there. Two kinds: a sward, and tussocks, which
// show farther away. The wind bends tips.
//
//   GRASS_BLADES   in a cell of the sward
//   GRASS_WIDER    times their width
//
// The block cover_map is there with the contract cover_light.
#include "cover/gust.glsl"

struct GrassKind {
    float span_m;     // what a pixel spans where it is gone
    int octave;       // cells of NESTED_BASE_M times 2 to this
    int blades;       // in a cell
    float tall;       // height of the highest in cells, for grass of GRASS_GIVEN_M
    float wide_m;     // half a blade's width at its foot
    float patchy;     // how much it stands in patches
};
const int GRASS_KINDS = 2;
const GrassKind GRASS[GRASS_KINDS] = GrassKind[](
    GrassKind(0.04, 2, GRASS_BLADES, 0.62, 0.0062 * GRASS_WIDER, 0.35),
    GrassKind(0.16, 3, (GRASS_BLADES + 1) / 2, 0.80, 0.010 * GRASS_WIDER, 0.9));
const int GRASS_CELLS = 6;            // on a ray
const float GRASS_SHADE = 0.08;       // of sun and sky that a closed sward takes from the ground
const vec2 GRASS_LIGHT = vec2(0.62, 2.2);   // of a blade's foot and tip, over that of the ground's plants
const float FLOWER_M = 0.016;         // radius
const vec3 FLOWERS[4] = vec3[](vec3(0.62, 0.60, 0.54), vec3(0.66, 0.48, 0.03), vec3(0.27, 0.13, 0.46),
    vec3(0.42, 0.05, 0.03));

// What is the same for all blades of a pixel.
struct GrassView {
    // Plane at right angles to the ray, in which distances from it are found. From places in the lattice, on the
    // ground: along; from heights above it: rise.
    mat2 along;
    vec2 rise;
    vec2 sway;        // what the wind moves tips by, over their height, along the lattice
    float grass, flowers;   // shares of what may stand
};

GrassView grass_view(ClutterView v, vec3 point, vec3 zenith, float grass, float flowers) {
    vec3 ray = -v.to_eye - v.eye_rise * v.up, x = cross(ray, v.up);
    x = dot(x, x) > 1e-6 ? normalize(x) : normalize(cross(ray, vec3(1.0, 0.0, 0.0)));
    vec3 y = cross(x, ray);
    vec2 lean = v.up.xy / v.up.z, a = x.xy - x.z * lean, b = y.xy - y.z * lean;
    vec2 sway = clutter_axes(cover_map.sway, zenith).xy * gust_at(point);
    return GrassView(mat2(a.x, b.x, a.y, b.y), vec2(dot(x, v.up), dot(y, v.up)), sway, grass, flowers);
}

// Of a pixel, by something half_wide to either side whose middle is away from the ray; width: the pixel's.
float grass_cover(float away, float half_wide, float width) {
    float seen = max(half_wide, 0.5 * width);
    return clamp((seen - away) / width + 0.5, 0.0, 1.0) * half_wide / seen;
}

void add_grass(
    inout GroundClutter found, inout float left, int kind, ClutterView v, GrassView grass, vec2 start, ivec2 first,
    ClutterBeach strand
) {
    GrassKind of = GRASS[kind];
    float size = NESTED_BASE_M * exp2(float(of.octave)), width = v.across / size;
    float here = clamp(2.0 - 2.0 * v.across / of.span_m, 0.0, 1.0) * v.strength * step(0.01, grass.grass);
    float highest = of.tall * cover_map.grass_tall;
    float along = here > 0.0 ? min(highest / max(v.eye_rise, 1e-3), float(GRASS_CELLS) - 1.0) : 0.0;
    vec3 ray = -v.to_eye;
    vec2 at = start - along * ray.xy, over = floor(at);
    ClutterRay r = ClutterRay(ray, -v.eye_rise, along, at - over, over - start + 0.25, first + ivec2(over), true);
    for (int i = 0; i < GRASS_CELLS && r.along > 0.0 && left > 0.05; ++i) {
        uvec2 seed = uvec2(r.column + 71) * 1664525u + 1013904223u;
        ivec3 bits = lattice_hash(seed.x, seed.y, uint(kind) * 747796405u + 1376312589u);
        vec3 one = vec3(bits & 0xfff) * (1.0 / 4095.0), two = vec3((bits >> 12) & 0xfff) * (1.0 / 4095.0);
        vec2 group = vec2(r.column & 4095) * (1.0 / 4096.0);
        float dense = clutter_wave(241.0 * group.x + 0.4 * clutter_wave(151.0 * group.y))
            + clutter_wave(199.0 * group.y + 0.4 * clutter_wave(113.0 * group.x));
        float beach = clamp(strand.here + dot(strand.slope, size * (r.corner + 0.5)), 0.0, 1.0);
        float open = 1.0 - beach, grows = clamp(grass.grass * open * (1.0 + of.patchy * (dense - 0.3)), 0.0, 1.0);
        float rise = r.along * v.eye_rise, tallest = highest * (0.35 + 0.65 * grows);   // rise: of the ray
        for (int k = 0; k < of.blades; ++k) {
            // Feet and tips of a cell lie evenly in it.
            vec2 foot = fract(one.xy + float(k) * vec2(0.7548777, 0.5698403));
            vec2 tip = fract(two.xy + float(k) * vec2(0.6180340, 0.3247180));
            float chance = fract(one.z + float(k) * 0.4142136);
            float tall = tallest * (0.4 + 0.6 * fract(two.z + float(k) * 0.7320508));
            float flutter = 0.25 * clutter_wave(cover_map.flutter + 7.0 * chance);
            tip = clamp(mix(foot, tip, 0.6) + tall * (1.0 + flutter) * grass.sway, 0.0, 1.0);
            vec2 a = grass.along * (foot - r.at) - grass.rise * rise;
            vec2 lean = grass.along * (tip - foot), up = grass.rise * tall, chord = lean + up;
            // The blade is a + up s + lean s^2, s from its foot to its tip.
            float s = clamp(-dot(a, chord) / max(dot(chord, chord), 1e-6), 0.0, 1.0);
            vec2 q = a + (up + lean * s) * s, d = up + 2.0 * s * lean;
            s = clamp(s - dot(q, d) / max(dot(d, d), 1e-6), 0.0, 1.0);
            float away = length(a + (up + lean * s) * s);
            float weight = left * here * step(chance, grows)
                * grass_cover(away, of.wide_m / size * (1.0 - s * s) + 1e-4, width);
            left -= weight;
            found.tint += weight * (2.0 * fract(7.0 * chance) - 1.0);
            found.plant += weight;
            found.light += weight * mix(GRASS_LIGHT.x, GRASS_LIGHT.y, s * tall / highest);
            vec2 bent = foot - tip;
            found.normal += weight * normalize(v.up + 0.5 * vec3(bent, -dot(bent, v.up.xy) / v.up.z));
        }
        // A flower in some cells, of the colour of its patch.
        vec2 head = fract(one.zx + 0.37), patch_at = vec2(r.column >> 4);
        float bloom = fract(two.z * 5.0 + one.x), tall = tallest * (0.75 + 0.3 * two.x);
        vec2 away = grass.along * (clamp(head + tall * grass.sway, 0.0, 1.0) - r.at) + grass.rise * (tall - rise);
        float colour = fract(dot(patch_at, vec2(0.7548777, 0.5698403)) + 0.35 * one.y);
        float broad_m = min(FLOWER_M * (0.7 + 0.6 * two.y) / size, 0.1), seen = max(broad_m, 0.5 * width);
        float weight = left * here * step(bloom, grass.flowers * open * clamp(0.5 + 0.6 * dense, 0.0, 1.5))
            * clamp((seen - length(away)) / width + 0.5, 0.0, 1.0) * broad_m * broad_m / (seen * seen)
            * clamp(8.0 * v.eye_rise, 0.0, 1.0);
        left -= weight;
        found.bloom += weight * FLOWERS[int(4.0 * colour) & 3];
        found.bloomed += weight;
        found.plant += weight;
        found.light += weight;
        found.normal += weight * v.up;
        next_cell(r);
    }
    // Between blades it is darker.
    float shade = GRASS_SHADE * here * grass.grass * (1.0 - clamp(strand.here, 0.0, 1.0));
    found.sun *= 1.0 - shade;
    found.sky *= 1.0 - shade;
}
