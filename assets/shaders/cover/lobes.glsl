// The ellipsoids of a broadleaf's crown, in the tree's own space (cover/tree.glsl): found once a tree.
const int TREE_LOBES = 7;
const float INNER_HIGH = 0.31;   // half the height of the one in the middle
const float LOBE_FLAT = 0.80;    // height over width of those around it
// Species, as systems/cover/species.py has them.
const float TREE_CONIFER = 1.0, TREE_ACACIA = 3.0, TREE_PALM = 4.0, TREE_DEAD = 5.0, TREE_COLUMN = 6.0,
    TREE_ROSETTE = 7.0;

// Around the trunk, by the golden angle.
const vec2 TREE_ANGLES[TREE_LOBES] = vec2[](vec2(1.0, 0.0), vec2(-0.73737, 0.67549), vec2(0.08743, -0.99617),
    vec2(0.60844, 0.79360), vec2(-0.98471, -0.17418), vec2(0.84376, -0.53673), vec2(-0.25960, 0.96571));

// Centres and radii. radius: of the crown; turn: 0..1, by chance.
void tree_lobes(float species, float radius, float turn, out vec4 lobes[TREE_LOBES]) {
    // Heights of the one in the middle, and of the lowest of others, and by how much they differ.
    bool palm = species == TREE_PALM;   // all of its fronds are in the one in the middle
    vec3 high = species == TREE_ACACIA ? vec3(0.88, 0.80, 0.11) : palm ? vec3(0.83, 0.83, 0.0) : vec3(0.66, 0.40, 0.40);
    lobes[0] = vec4(0.0, 0.0, high.x, (palm ? 1.0 : 0.74) * radius);
    for (int k = 1; k < TREE_LOBES; ++k) {
        float up = fract(0.618034 * float(k) + 3.7 * turn), wide = fract(5.3 * turn + 0.381966 * float(k));
        // None reaches beyond the crown's radius.
        float aside = 0.42 + 0.20 * up, size = min(0.40 + 0.22 * wide, 1.0 - aside);
        lobes[k] = vec4(radius * aside * TREE_ANGLES[k], high.y + high.z * up, palm ? 1e-4 : radius * size);
    }
}
