// What the ground is made of at a pixel: materials in the shares that their rules give (systems/terrain/materials.py,
// of which terrain_material() is made).
#include "terrain/ground_at.glsl"

struct Ripples {
    float share;   // how clearly they show, 0..1
    int octave;      // their wavelength is 0.036 m times 2 to this
    float bend;    // of crests, in wavelengths
    float slope;   // of the steepest places, metres per metre
    float tint;    // how much lighter crests are, as a share
};

// Shares of cells of clutter that hold one, off the beach.
struct Growth {
    float tufts, tussocks, shrubs, trees;
    float wooded;   // 0..1: under trees
    float flowers;  // of cells with grass, that may have one: few where it is dry, cold or shady
};

struct Material {
    vec3 albedo;
    float grain;      // height of the bumps below the terrain's shortest layer
    float rock;       // share of bare rock
    float stony;      // of cells of clutter that hold a stone, off the beach
    Growth growth;    // and that hold a plant
    vec3 plant;       // albedo of plants
#ifdef GROUND_COVER
    float inland;     // share of the pixel that may have woods: off the beach, and where a map has some
#endif
    Ripples ripples;  // of loose ground
};

// Without branches.
Ripples stronger(Ripples a, Ripples b) {
    bool other = b.share > a.share;
    return Ripples(other ? b.share : a.share, other ? b.octave : a.octave, other ? b.bend : a.bend,
        other ? b.slope : a.slope, other ? b.tint : a.tint);
}

// What stands on it: plants, fewer where it is dry, and stones. All this hangs on the place alone, not on the pixel's
// footprint, so nothing comes or goes when the camera moves. Beaches count where a thing has its foot
// (terrain/clutter.glsl). stones, plants, trees: what the materials leave of them.
void stand_on(inout Material material, Ground ground, float stones, float plants, float trees) {
    float wet = ramp(0.25, 0.55, ground.mean_humidity) * ground.plants, growing = wet * plants;
    float woods = ground.wooded * ramp(0.50, 0.72, ground.mean_humidity) * ramp(0.15, 0.28, ground.mean_warmth);
    material.stony = (0.04 + 0.3 * (1.0 - growing) + 0.15 * ground.roughness) * stones;
    material.growth =
        Growth(growing * 0.95, growing * 0.32, ground.wooded * growing * (0.10 + 0.45 * woods),
            wet * trees * woods, woods, wet * growing * ramp(0.03, 0.2, ground.mean_warmth - 0.3 * ground.winter)
            * (1.0 - 0.7 * woods));
}

#include "generated/terrain_materials.glsl"
