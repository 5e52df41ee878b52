// Where a ray meets a tree: a trunk, and tufts of leaves in a crown. A broadleaf's crown is made of ellipsoids, a
// conifer's is a cone of whorls. Through either the ray is followed in steps as long as a tuft: what it passes are
// leaves or gaps between them, by chance.
//
// Lengths in the tree's own space, where it is 1 high, its foot is at 0 and z points up.
#include "common/constants.glsl"
#include "cover/lobes.glsl"

const float TUFT_M = 0.13;            // size of a tuft of leaves
const float SMALL_TUFT = 0.13;         // over a crown's radius: of shrubs
const int TREE_STEPS = 9;             // into a lobe
const int TREE_TURNS = 3;              // lobes that a ray is followed through
const int CONIFER_STEPS = 9;          // into the cone
const float CLUMPS = 1.9, CLUMPS_DEEP = 0.48;  // waves in a crown's radius; how far they shape a lobe's rim
const float SPRAYS = 2.6, SPRAYS_DEEP = 0.34;  // smaller waves in one of those; how deep they are
const float CLUMPS_RIM = 0.55, CLUMPS_BULGE = 0.35;   // clump at a lobe's rim; of what is higher, what bulges out
const float RAGGED = 0.9;             // of a tuft's size, how far its outline moves out and in
const float TUFTS_DIFFER = 0.5;       // of light, from one tuft to another
const float BRANCH_HANGS = 0.6, ALONG_BRANCH = 0.8;   // of a conifer; how far its tufts lie along it
const float LEAF_ROWS = 4.0, NEEDLE_ROWS = 6.5, LEAF_LONG = 1.9;   // a tuft's width over a leaf's, over its length
const float LEAF_PIXEL = 0.15;        // what a pixel spans of a tuft where its leaves show
const float TWIGS = 0.30;             // share of a crown's tufts that leaves no twig behind
const float TWIG_THIN = 60.0;
const float BARK_FURROWS = 25.0;      // around a trunk
const float TREE_TRUNK = 0.022;       // radius of the trunk at its foot
const float ACACIA_TRUNK = 0.027, PALM_TRUNK = 0.016;
const float LIMB = 0.009;             // of a limb
const float ACACIA_LIMB = 1.6;        // over that
// Heights of a palm's fronds, of both rings: where they begin, and how they go on outwards.
const vec2 FRONDS_FOOT = vec2(0.90, 0.87), FRONDS_RISE = vec2(0.27, 0.10), FRONDS_HANG = vec2(0.27, 0.27);
const float FROND_THICK = 0.030;
const float FROND_LEAF = 1.7;         // size of their tufts over others'
const float CONIFER_FOOT = 0.07;      // height of the lowest branches
const float TREE_WHORLS = 11.0;
const mat3 TUFT_LATTICE = mat3(0.36, 0.48, -0.80, -0.80, 0.60, 0.00, 0.48, 0.64, 0.60);   // a rotation

struct TreeHit {
    float t;       // along the ray; below 0: none
    vec3 normal;
    float open;    // 0..1: share of the light from around that leaves of the same tree leave
    float bark;    // 1: the trunk
};

// What is the same all along a ray.
struct TreeRay {
    vec3 from, ray;   // ray: 1 long
    float radius;     // of the crown
    float turn;       // 0..1
    float size;       // of a tuft, but no less than a pixel shows
    float fine;       // 0: a pixel is wider than tufts
    float rows;       // of leaves in a tuft; 0: a pixel doesn't show them
    float bare;       // 0..1: twigs without leaves
    bool flat_top;    // an acacia or a palm
    bool palm;
    float leaves;     // how closed the crown is; 1: as most are
};

uint tree_mix(uint x) {
    x = (x ^ (x >> 16)) * 0x7feb352du;
    x = (x ^ (x >> 15)) * 0x846ca68bu;
    return x ^ (x >> 16);
}

float tree_wave(float x) {
    return abs(4.0 * fract(x) - 2.0) - 1.0;
}

// Chance of a cell, three numbers 0..1.
vec3 tree_chance(ivec3 cell, uint seed) {
    uint h = tree_mix(uint(cell.x) * 0x9e3779b9u + uint(cell.y) * 0x85ebca6bu + uint(cell.z) * 0xc2b2ae35u ^ seed);
    return vec3(uvec3(h, h >> 10, h >> 20) & 1023u) * (1.0 / 1023.0);
}

// Whether there is a tuft at a step. dense: 0..1, share of cells that have one; branch: what it stands along, 0 for
// none; normal: of the tuft; light: how much more of it than others it has, -1..1.
bool tree_tuft(TreeRay r, vec3 place, float dense, vec3 branch, uint seed, out vec3 normal, out float light) {
    // On a turned lattice, and far from the middles of its cells: rows of a straight one would show.
    vec3 at = TUFT_LATTICE * place / r.size, cell = floor(at), along = TUFT_LATTICE * r.ray;
    vec3 chance = tree_chance(ivec3(cell), seed), lies = chance.yzx - 0.5;
    lies += cross(TUFT_LATTICE * branch, along);   // longest along its branch
    light = chance.y - chance.z;
    vec3 away = at - cell - 0.5 - 0.8 * (chance.zxy - 0.5);
    away -= dot(away, along) * along;   // of the ray from the tuft's middle
    normal = (1.8 * away + 0.6 * lies) * TUFT_LATTICE - 0.4 * r.ray;
    // Longer than wide.
    float across = dot(away, lies);
    // Twigs are thinner than leaves.
#ifdef COVER_SPECIES
    dense *= r.leaves;
#endif
    float large = mix(0.45, 0.30, r.fine) * (0.6 + 0.8 * chance.y);
#ifdef TREE_LIMBS
    // Of leaves that stand out on all sides, where a tuft is more than a pixel or two.
    large *= 1.0 + RAGGED * r.fine * tree_wave(1.7 * away.x + 0.9 * away.y + chance.z)
        * tree_wave(1.9 * away.z - 0.8 * away.y + chance.y);
#endif
    bool within = chance.x < dense
        && dot(away, away) + mix(7.0, TWIG_THIN, r.bare) * r.fine * across * across < large;
#ifdef TREE_LEAVES
    // So near that its leaves show: they stand along a stem, to both of its sides.
    vec3 side = normalize(lies - dot(lies, along) * along + 1e-4), stem = cross(along, side);
    float aside = dot(away, side), out_share = abs(aside) * LEAF_LONG;
    float row = fract(r.rows * (dot(away, stem) - 0.6 * abs(aside)) + (aside > 0.0 ? 0.5 : 0.0)) - 0.5;
    within = within && (r.rows == 0.0 || abs(row) < 1.15 * sqrt(out_share) * (1.0 - out_share) || out_share < 0.04);
    normal += (r.rows > 0.0 ? 0.5 * sign(aside) + 1.6 * row : 0.0) * (side * TUFT_LATTICE);
#endif
    return within;
}

// Clumps of leaves, about -1..1: waves that bend one another, and smaller ones. place: in crown radii.
float tree_clump(vec3 place, float turn) {
    vec3 at = CLUMPS * place + vec3(7.0, 11.0, 13.0) * turn;
    vec3 waves = abs(4.0 * fract(at + 0.3 * at.yzx) - 2.0) - 1.0;
    vec3 small = abs(4.0 * fract(SPRAYS * at.zxy + 0.35 * waves) - 2.0) - 1.0;
    return 0.55 * (waves.x + waves.y + waves.z) + SPRAYS_DEEP * (small.x + small.y + small.z);
}

// How much of the light from around reaches a place in the crown. outer: 0 in its middle, 1 at its rim; up: -1..1.
float tree_open(float outer, float up, float chance) {
    return clamp(0.16 + 0.62 * outer * outer + 0.20 * up - 0.12 * chance, 0.08, 1.0);
}

// Two rings of nine fronds, which rise and bend down, and which hang between them: above 0 within one.
float palm_frond(TreeRay r, vec3 place) {
    float aside2 = dot(place.xy, place.xy), cosine = place.x * inversesqrt(aside2 + 1e-8);
    cosine = (4.0 * cosine * cosine - 3.0) * cosine;   // of three times the angle
    cosine = (4.0 * cosine * cosine - 3.0) * cosine;   // of nine times
    float out2 = aside2 / (r.radius * r.radius), out1 = sqrt(out2);
    vec2 off = place.z - FRONDS_FOOT - FRONDS_RISE * out1 + FRONDS_HANG * out2;
    off /= max(FROND_THICK, 0.7 * r.size);   // no thinner than a step
    vec2 within = 0.8 - off * off - mix(0.4, 1.1, r.fine) * (0.5 - vec2(cosine, -cosine)) * min(5.0 * out2, 1.0);
    return max(within.x, within.y) - max(8.0 * out2 - 6.8, 0.0);
}

// Lobes are tried in the order in which the ray enters them: the first ones close nearly all of them.
void tree_broadleaf(inout TreeHit found, TreeRay r, vec4 lobes[TREE_LOBES], uint seed) {
    // Flat ones: height over width of lobes, half the height of the inner one; the crown's middle, half its height.
    vec4 shape = r.palm ? vec4(0.34, 0.17, 0.83, 0.17) : r.flat_top ? vec4(0.34, 0.055, 0.87, 0.14)
        : vec4(LOBE_FLAT, INNER_HIGH, 0.62, 0.36);
    vec3 outer_squash = vec3(1.0, 1.0, 1.0 / shape.x), inner_squash = vec3(1.0, 1.0, lobes[0].w / shape.y);
    vec3 middle = vec3(0.0, 0.0, shape.z);
    float last = -1e9;
    for (int turn = 0; turn < TREE_TURNS; ++turn) {
        float begin = 1e9, end = 0.0;
        vec4 lobe = vec4(0.0);
        bool inner = false;
        for (int k = 0; k < TREE_LOBES; ++k) {
            vec3 squash = k == 0 ? inner_squash : outer_squash, d = r.ray * squash;
            vec3 o = (r.from - lobes[k].xyz) * squash;
            float dd = dot(d, d), b = dot(o, d), root = b * b - dd * (dot(o, o) - lobes[k].w * lobes[k].w);
            float half_chord = sqrt(max(root, 0.0)), in_t = (-b - half_chord) / dd, out_t = (half_chord - b) / dd;
            if (root > 0.0 && out_t > 0.0 && in_t > last && in_t < begin) {
                begin = in_t;
                end = out_t;
                lobe = lobes[k];
                inner = k == 0;
            }
        }
        last = begin;
        end = found.t > 0.0 ? min(end, found.t) : end;
        if (begin >= end) break;
        vec3 squash = inner ? inner_squash : outer_squash, o = (r.from - lobe.xyz) * squash / lobe.w;
        vec3 d = r.ray * squash / lobe.w;
        float t = max(begin, 0.0) + 0.3 * r.size;
        for (int i = 0; i < TREE_STEPS && t < end; ++i) {
            float light;
            vec3 place = r.from + t * r.ray, level = o + t * d, tuft;
            float clump = tree_clump(place / r.radius, r.turn);
            // 0 where leaves begin. Clumps that reach far out would be cut off along the lobe's smooth outline.
            float bulge = clump - CLUMPS_RIM;
            float inside = 1.0 - dot(level, level) + CLUMPS_DEEP * min(bulge, CLUMPS_BULGE * bulge);
            inside = r.palm ? palm_frond(r, place) : inside;
            // Sparse at the rim, closed within.
            float dense = clamp(0.12 + 1.6 * inside, 0.0, 0.92) * (1.0 - TWIGS * r.bare);
            if (tree_tuft(r, place, dense, vec3(0.0), seed, tuft, light)) {
                vec3 away = place - middle, share = away / vec3(r.radius, r.radius, shape.w);
                vec3 crown = normalize(level * squash + 0.8 * away / r.radius + vec3(0.0, 0.0, 0.25));
                found = TreeHit(t, normalize(crown + (0.55 * r.fine) * tuft),
                    tree_open(length(share), clamp(share.z, -1.0, 1.0), dot(tuft, tuft))
                        * clamp(0.72 + 0.55 * clump + TUFTS_DIFFER * r.fine * light, 0.2, 1.25), 0.0);
                return;
            }
            t += inside > 0.0 ? r.size : 2.0 * r.size;
        }
    }
}

void tree_conifer(inout TreeHit found, TreeRay r, uint seed) {
    // A cone with its tip at z = 1: |xy| = slope (1 - z).
    float slope = r.radius / (1.0 - CONIFER_FOOT);
    vec3 o = r.from - vec3(0.0, 0.0, 1.0);
    float a = dot(r.ray.xy, r.ray.xy) - slope * slope * r.ray.z * r.ray.z;
    float b = dot(o.xy, r.ray.xy) - slope * slope * o.z * r.ray.z, c = dot(o.xy, o.xy) - slope * slope * o.z * o.z;
    float root = b * b - a * c;
    if (root <= 0.0) return;
    root = sqrt(root);
    float one = (-b - root) / a, two = (-b + root) / a, begin = max(min(one, two), 0.0), end = max(one, two);
    // Not the cone's mirror image above its tip, nor below its foot.
    float low = (CONIFER_FOOT - r.from.z) / r.ray.z, high = (1.0 - r.from.z) / r.ray.z;
    if (abs(r.ray.z) > 1e-4) {
        if (a < 0.0) {   // steeper than the cone: in from one side, on to the foot
            bool inside = c < 0.0 && o.z < 0.0;
            float in_t = one > 0.0 && o.z + one * r.ray.z < 0.0 ? one
                : two > 0.0 && o.z + two * r.ray.z < 0.0 ? two : 1e9;
            begin = inside ? 0.0 : in_t;
            end = 1e9;
        }
        begin = max(begin, min(low, high));
        end = min(end, max(low, high));
    }
    end = found.t > 0.0 ? min(end, found.t) : end;
    float t = begin + 0.3 * r.size;
    for (int i = 0; i < CONIFER_STEPS && t < end; ++i) {
        float light;
        vec3 place = r.from + t * r.ray, tuft;
        float wide = slope * (1.0 - place.z), aside = length(place.xy);
        // Whorls: branches that hang, with gaps between their tips.
        float sine = place.y / max(aside, 1e-4), tips = sine * (3.0 - 4.0 * sine * sine);   // of three times the angle
        float whorl = fract(TREE_WHORLS * place.z + 0.55 * aside / max(wide, 0.01) + 0.2 * tips + r.turn);
        float reach = wide * (1.0 - 0.42 * whorl - 0.08 * tips * tips);
        float inside = 1.0 - aside / max(reach, 1e-3);
        vec3 branch = ALONG_BRANCH * vec3(place.xy / max(aside, 1e-4), -BRANCH_HANGS);
        float dense = clamp(0.5 + 3.0 * inside, 0.0, 0.97);
        if (inside > 0.0 && tree_tuft(r, place, dense, branch, seed, tuft, light)) {
            vec3 crown = normalize(vec3(place.xy / max(wide, 0.01), 0.35 + 0.5 * (1.0 - whorl)));
            found = TreeHit(t, normalize(crown + (0.45 * r.fine) * tuft),
                tree_open(clamp(aside / max(wide, 0.01), 0.0, 1.0), 0.7 - 1.6 * whorl, dot(tuft, tuft))
                    * (1.0 + TUFTS_DIFFER * r.fine * light), 0.0);
            break;
        }
        t += r.size;
    }
}

// The trunk: a cone that ends in the crown.
void tree_trunk(inout TreeHit found, TreeRay r, float height) {
    float foot = r.palm ? PALM_TRUNK : r.flat_top ? ACACIA_TRUNK : TREE_TRUNK;
    float slope = foot / height, wide = foot - slope * r.from.z;   // at the height of `from`
    float a = dot(r.ray.xy, r.ray.xy) - slope * slope * r.ray.z * r.ray.z;
    float b = dot(r.from.xy, r.ray.xy) + slope * wide * r.ray.z, root = b * b - a * (dot(r.from.xy, r.from.xy)
        - wide * wide);
    if (root < 0.0 || a <= 0.0) return;
    float t = (-b - sqrt(root)) / a, z = r.from.z + t * r.ray.z;
    if (t <= 0.0 || z < -0.05 || z > height) return;
    vec3 out_xy = normalize(vec3((r.from + t * r.ray).xy, 0.0));
    // Furrows along it, which bend and end.
    float around = BARK_FURROWS / (2.0 * PI) * atan(out_xy.y, out_xy.x);
    float furrow = tree_wave(around + 0.35 * tree_wave(31.0 * z + 0.2 * around) + 3.0 * z)
        * (0.55 + 0.45 * tree_wave(17.0 * z + 0.36 * around));
    found = TreeHit(t, out_xy, mix(0.7, 0.25, z / height) * (1.0 + 0.25 * furrow * r.fine), 1.0);
}

// Limbs: cylinders from the trunk to the middles of the lobes.
void tree_limbs(inout TreeHit found, TreeRay r, vec4 lobes[TREE_LOBES], float thick) {
    for (int k = 1; k < TREE_LOBES; ++k) {
        vec3 foot = vec3(0.0, 0.0, 0.62 * lobes[k].z), along = lobes[k].xyz - foot, from = r.from - foot;
        float long_2 = dot(along, along), ray_along = dot(r.ray, along), from_along = dot(from, along);
        float a = long_2 - ray_along * ray_along, b = long_2 * dot(from, r.ray) - from_along * ray_along;
        float c = long_2 * (dot(from, from) - thick * thick) - from_along * from_along, root = b * b - a * c;
        float t = (-b - sqrt(max(root, 0.0))) / a, share = (from_along + t * ray_along) / long_2;
        if (thick > 0.0 && root > 0.0 && t > 0.0 && share > 0.0 && share < 0.9 && (found.t < 0.0 || t < found.t))
            found = TreeHit(t, normalize(from + t * r.ray - share * along), 0.45 - 0.25 * share, 1.0);
    }
}

#ifdef COVER_FORMS   // in programs of their own: no tree pays for them
#include "cover/column.glsl"
#include "cover/rosette.glsl"

#endif
// from, ray: in the tree's space, ray 1 long. radius: of the crown. pixel: what a pixel spans there. leaf: size of a
// tuft of leaves; lobes: as tree_lobes() has them; bare: share of leaves that have fallen; leaves: as TreeRay has them.
TreeHit tree_hit(
    float species, vec3 from, vec3 ray, float radius, float turn, vec4 lobes[TREE_LOBES], float pixel, float leaf,
    float bare, float leaves
) {
    TreeHit found = TreeHit(-1.0, vec3(0.0), 1.0, 0.0);
    bool conifer = species == TREE_CONIFER;
    leaf *= species == TREE_PALM ? FROND_LEAF : 1.0;
    TreeRay r = TreeRay(from, ray, radius, turn, max(leaf, 1.3 * pixel), clamp(2.0 - 0.8 * pixel / leaf, 0.0, 1.0),
        pixel < LEAF_PIXEL * leaf ? conifer ? NEEDLE_ROWS : LEAF_ROWS : 0.0,
        bare, species == TREE_ACACIA || species == TREE_PALM, species == TREE_PALM, leaves);
#ifdef COVER_FORMS
    if (species == TREE_COLUMN) tree_column(found, r);
    else tree_rosette(found, r, pixel);
#else
    tree_trunk(found, r, conifer || r.flat_top ? 1.0 : 0.8);
    uint seed = floatBitsToUint(turn + 1.0);
    if (conifer) tree_conifer(found, r, seed);
    else {
#ifdef TREE_LIMBS
        float limb = LIMB * (species == TREE_ACACIA ? ACACIA_LIMB : r.palm ? 0.0 : 1.0);
        tree_limbs(found, r, lobes, limb * clamp(2.0 - pixel / max((r.flat_top ? 0.9 : 0.3) * limb, 1e-6), 0.0, 1.0));
#endif
        tree_broadleaf(found, r, lobes, seed);
    }
#endif
    return found;
}
