// Stones near the camera: one in some of the cells of a lattice, its middle inside the cell, so that no
// neighbour has to be asked. Their sizes are the world's, 2 to 17 cm; they go where a pixel can't show them any more, and cost
// nothing from there on. The ground cuts the lattice in a plane, which shows a disc of each: a dome on the ground.
#include "generated/terrain_material_block.glsl"
#include "common/nested_noise.glsl"

struct GroundStones {
    float cover;    // 0..1: the pixel lies on one
    float tint;     // -1..1, the same all over one
    float shade;    // 0..1: light that its foot leaves to the ground around it
    vec3 gradient;  // of the dome, metres per metre
};

const float STONE_STEEP = 0.9;

// plenty: share of cells that hold one. wobble: noise that makes their outlines uneven.
GroundStones ground_stones(vec3 D, vec3 zenith, float footprint, float plenty, float wobble) {
    GroundStones found = GroundStones(0.0, 0.0, 1.0, vec3(0.0));
    int turns = footprint < 0.05 ? 2 : 0;
    for (int i = 0; i < turns; ++i) {
        ivec3 cell;
        vec3 fraction;
        float frequency;
        nested_place(terrain_material_block.anchor_cell.xyz, terrain_material_block.anchor_fraction.xyz, D, i == 0 ? 3 : 1, cell,
            fraction, frequency);
        uvec3 seed = uvec3(cell + 71) * 1664525u + 1013904223u;
        ivec3 bits = lattice_hash(seed.x, seed.y, seed.z);
        vec3 place = vec3(bits & 0x3ff) * (1.0 / 1023.0), more = vec3((bits >> 12) & 0x3ff) * (1.0 / 1023.0);
        float radius = mix(0.12, 0.34, more.x * more.x);
        vec3 d = fraction - mix(vec3(1.4 * radius), vec3(1.0 - 1.4 * radius), place);
        float above = dot(d, zenith);
        vec3 aside = d - above * zenith;
        float disc2 = radius * radius - above * above;
        float inverse = inversesqrt(max(disc2, 0.0016)), at = length(aside) * inverse * (1.0 + wobble), width = footprint * frequency * inverse;
        float seen = (disc2 > 0.0025 && more.y < plenty ? 1.0 : 0.0) * clamp(2.0 - 20.0 * footprint * frequency, 0.0, 1.0);
        float cover = seen * clamp(0.5 + (1.0 - at) / max(width, 0.05), 0.0, 1.0);
        found.shade *= 1.0 - 0.5 * seen * (1.0 - cover) * clamp((1.4 - at) * 2.5, 0.0, 1.0);
        found.gradient = mix(found.gradient, -2.0 * STONE_STEEP * inverse * min(at, 1.0) / max(at, 1e-3) * aside, cover);
        found.tint = mix(found.tint, 2.0 * more.z - 1.0, cover);
        found.cover = max(found.cover, cover);
    }
    return found;
}
