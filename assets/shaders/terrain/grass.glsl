// Grass and flowers near the camera: tufts that stand in the cells of a square lattice, each from its foot to its tips
// inside one cell, so that no neighbour has to be asked. The pixel's ray is followed through the cells from the eye to
// the ground. A tuft is a fan of blades around a bent curve: its place and bend are worked out once, and the pixel
// takes the one blade that it is nearest to, which covers as much of the pixel as it is wide there. Two kinds:
// tussocks, which show farther away, and a sward between them. The wind bends tips.
//
//   GRASS_BLADES   three for each two tufts in a cell of the sward
//   GRASS_WIDER    times the width of blades
//
// The block cover_map is there with the contract cover_light.
#include "cover/gust.glsl"

struct GrassKind {
    float span_m;     // what a pixel spans where it is gone
    int octave;       // cells of NESTED_BASE_M times 2 to this
    int tufts;        // in a cell
    float tall;       // height of the highest in cells, for grass of GRASS_GIVEN_M
    float wide_m;     // half a blade's width at its foot
    float apart;      // of blades of a tuft at their tips, in cells
    float patchy;     // how much it stands in patches
    float shade;      // of sun and sky that it takes from the ground where it is closed
};
const int GRASS_KINDS = 2, GRASS_TUFTS = (2 * GRASS_BLADES + 1) / 3;
const GrassKind GRASS[GRASS_KINDS] = GrassKind[](
    GrassKind(0.16, 3, (GRASS_TUFTS + 1) / 2, 0.80, 0.0072 * GRASS_WIDER, 0.040, 0.9, 0.07),
    GrassKind(0.04, 2, GRASS_TUFTS, 0.62, 0.0047 * GRASS_WIDER, 0.055, 0.30, 0.20));
const int GRASS_CELLS = 6;            // on a ray
const float GRASS_FAN = 3.0;          // blades to either side of a tuft's middle one
// Over the light of the ground's plants: of a blade's foot, of its tip from the side, where little but tips shows, and
// from above. Chosen so that grass is as light as the ground without it.
const vec3 GRASS_LIGHT = vec3(0.70, 1.48, 1.9);

#include "terrain/flowers.glsl"

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

void add_grass(
    inout GroundClutter found, inout float left, inout Flower flower, int kind, ClutterView v, GrassView grass,
    vec2 start, ivec2 first, ClutterBeach strand
) {
    GrassKind of = GRASS[kind];
    float size = NESTED_BASE_M * exp2(float(of.octave)), width = v.across / size;
    float here = clamp(2.0 - 2.0 * v.across / of.span_m, 0.0, 1.0) * v.strength * step(0.01, grass.grass);
    // No higher than the ray's cells reach: tips that they miss would be cut off.
    float highest = min(of.tall * cover_map.grass_tall, (float(GRASS_CELLS) - 1.0) * v.eye_rise);
    float along = here > 0.0 ? highest / max(v.eye_rise, 1e-3) : 0.0;
    vec3 ray = -v.to_eye;
    vec2 at = start - along * ray.xy, over = floor(at), bent = vec2(0.0);
    float wide = of.wide_m / size, covered = 0.0;
    float tip_light = mix(GRASS_LIGHT.y, GRASS_LIGHT.z, min(2.5 * v.eye_rise, 1.0));
    ClutterRay r = ClutterRay(ray, -v.eye_rise, along, at - over, over - start + 0.25, first + ivec2(over), true);
    for (int i = 0; i < GRASS_CELLS && r.along > 0.0 && left > 0.05; ++i) {
        uvec2 seed = uvec2(r.column + 71) * 1664525u + 1013904223u;
        ivec3 bits = lattice_hash(seed.x, seed.y, uint(kind) * 747796405u + 1376312589u);
        vec3 one = vec3(bits & 0xfff) * (1.0 / 4095.0), two = vec3((bits >> 12) & 0xfff) * (1.0 / 4095.0);
        vec2 group = vec2(r.column & 4095) * (1.0 / 4096.0);
        float dense = clutter_wave(241.0 * group.x + 0.8 * clutter_wave(151.0 * group.y))
            + clutter_wave(199.0 * group.y + 0.8 * clutter_wave(113.0 * group.x));
        float beach = clamp(strand.here + dot(strand.slope, size * (r.corner + 0.5)), 0.0, 1.0);
        float open = 1.0 - beach, grows = clamp(grass.grass * open * (1.0 + of.patchy * (dense - 0.3)), 0.0, 1.0);
        float rise = r.along * v.eye_rise, tallest = highest * (0.35 + 0.65 * grows);   // rise: of the ray
        float per_tallest = 1.0 / tallest;
        Bloom bloom = flower_bloom(group, one, two, grass.flowers * open);
        float before = left;
        vec2 tip_at;
        for (int k = 0; k < of.tufts; ++k) {
            bool stem = bloom.there && k == of.tufts - 1;
            // Feet and tips of a cell lie evenly in it.
            vec2 foot = 0.1 + 0.8 * fract(one.xy + float(k) * vec2(0.7548777, 0.5698403));
            vec2 tip = fract(two.xy + float(k) * vec2(0.6180340, 0.3247180));
            float chance = fract(one.z + float(k) * 0.4142136);
            float tall = tallest * (stem ? 1.2 : 0.4 + 0.6 * fract(two.z + float(k) * 0.7320508));
            float flutter = 0.25 * clutter_wave(cover_map.flutter + 7.0 * chance);
            tip = clamp(mix(foot, tip, 0.6) + tall * (1.0 + flutter) * grass.sway, 0.0, 1.0);
            vec2 a = grass.along * (foot - r.at) - grass.rise * rise;
            vec2 lean = grass.along * (tip - foot), up = grass.rise * tall, chord = lean + up;
            tip_at = a + chord;
            // The middle of the tuft is a + up s + lean s^2, s from its foot to its tip.
            float s = clamp(-dot(a, chord) / max(dot(chord, chord), 1e-6), 0.0, 1.0);
            vec2 q = a + (up + lean * s) * s, d = up + 2.0 * s * lean;
            float per_way = 1.0 / max(dot(d, d), 1e-6);
            s = clamp(s - dot(q, d) * per_way, 0.0, 1.0);
            q = a + (up + lean * s) * s;
            vec2 way = d * sqrt(per_way);
            // The blade of the fan that is nearest, and how far away that is.
            float aside = q.x * way.y - q.y * way.x, gap = of.apart * (0.3 + s);
            float blade = clamp(floor(aside / gap + 0.5), -GRASS_FAN, GRASS_FAN);
            float own = fract(13.0 * chance + 0.6180340 * blade);
            float away = abs(aside - gap * (blade + 0.8 * own - 0.4)) + abs(dot(q, way));
            float upwards = stem && blade == 0.0 ? s : s * (1.0 + own);
            // A pixel wider than the fan's gaps shows as much of each blade as lies in one gap.
            float spans = min(width, gap);
            float half_wide = wide * max(1.0 - upwards * upwards, 0.0), seen = max(half_wide, 0.5 * spans);
            float weight = left * here * step(chance, grows)
                * clamp((seen - away) / spans + 0.5, 0.0, 1.0) * half_wide / seen;
            left -= weight;
            float height = min(upwards, 1.0) * (0.5 + 0.5 * tall * per_tallest);
            found.tint += weight * (2.0 * own - 1.0);
            found.dry += weight * (0.2 * height + step(0.93, fract(7.0 * own + chance)));
            found.light += weight * mix(GRASS_LIGHT.x, tip_light, height) * (0.25 + 1.5 * fract(5.0 * chance));
            bent += weight * (foot - tip);
        }
        find_flower(flower, bloom, tip_at, before * here * step(flower.left, 0.0), size, v.across);
        next_cell(r);
        covered += before - left;
    }
    found.plant += covered;
    found.normal += covered * v.up + 0.5 * vec3(bent, -dot(bent, v.up.xy) / v.up.z);
    // Between blades it is darker.
    float shade = of.shade * here * grass.grass * (1.0 - clamp(strand.here, 0.0, 1.0));
    found.sun *= 1.0 - shade;
    found.sky *= 1.0 - shade;
}
