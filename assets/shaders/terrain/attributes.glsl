// What the G-buffer keeps of a point of the ground for its materials: the root of roughness / 1.3, moisture, height
// between the planet's lowest and highest ground (never 0, which stands for unknown), the code of the spacing that its
// vertices have.
#include "common/spacing_code.glsl"

vec4 terrain_attributes(TerrainPoint terrain, float height, float spacing_m) {
    float coded = (height - planet.lowest_m) / max(planet.highest_m - planet.lowest_m, 1.0);
    return vec4(sqrt(terrain.roughness / 1.3), terrain.moisture, clamp(coded, 1.0 / 255.0, 1.0),
        spacing_encode(spacing_m));
}

float terrain_roughness(vec4 attributes) {
    return 1.3 * attributes.x * attributes.x;
}
