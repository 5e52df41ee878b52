// Stands of a forest: patches of older and younger trees, of lighter and darker greens, and glades between them. Twin
// of systems/cover/stands.py, so that woods go on where trees are no longer solids.
#include "cover/hue.glsl"

const int STAND_OCTAVE = 12, GROUP_OCTAVE = 10;   // 256 m and 64 m
const vec2 STAND_AGE = vec2(1.5, 0.6), STAND_HUE = vec2(1.5, 0.8), STAND_GLADE = vec2(0.75, 0.65);   // of both
const vec2 STAND_REGION = vec2(0.20, 0.30);       // of noise of a kilometre, in age and hue
const vec2 GLADE_ENDS = vec2(-0.46, -0.62);       // where glades begin, and are open
const float GLADE_BARE = 0.85;                    // of their places that have no tree
const vec2 STAND_GRAIN = vec2(0.35, 0.22);        // of finer noise in their colour; where stands differ
const float STAND_WIDER = 0.2;                    // area of crowns of many sizes, more than of equal ones
const float STAND_CONIFERS = 0.08;                // by what darker ones count as colder
const vec2 STAND_SIZES = vec2(0.16, 0.25);        // of the widths of crowns and of heights, by age

struct Stand {
    float age;   // -1..1: young and old
    float hue;   // -1..1: of dark, bluish and of light, yellowish leaves
    float open;  // 0..1: share of the places that have no tree
};

// Octaves shorter than a few pixels are their mean, 0.
vec3 stand_noise(vec3 D, int k, float footprint_m) {
    ivec3 cell;
    vec3 fraction;
    float frequency;
    nested_place(terrain_material_block.anchor.cell, terrain_material_block.anchor.fraction, D, k, cell, fraction,
        frequency);
    mat3 unused;
    return vector_noise(cell, fraction, unused) * ramp(0.5, 0.2, footprint_m * frequency);
}

// region: noise of a kilometre.
Stand stand_at(vec3 D, float region, float footprint_m) {
    vec3 wide = stand_noise(D, STAND_OCTAVE, footprint_m), narrow = stand_noise(D, GROUP_OCTAVE, footprint_m);
    float age = clamp(STAND_AGE.x * wide.x + STAND_AGE.y * narrow.x + STAND_REGION.x * region, -1.0, 1.0);
    float hue = clamp(STAND_HUE.x * wide.y + STAND_HUE.y * narrow.y + STAND_REGION.y * region, -1.0, 1.0);
    float open = GLADE_BARE
        * ramp(GLADE_ENDS.x, GLADE_ENDS.y, STAND_GLADE.x * wide.z + STAND_GLADE.y * narrow.z);
    return Stand(cover_map.variety * age, cover_map.variety * hue, cover_map.variety * open);
}

// Area of its crowns over that of equal ones.
float stand_crowns(Stand stand) {
    float wide = 1.0 + STAND_SIZES.x * stand.age;
    return wide * wide * (1.0 + STAND_WIDER * cover_map.variety);
}

float stand_grain() {
    return mix(STAND_GRAIN.x, STAND_GRAIN.y, cover_map.variety);
}
