// The height of the ground. First version: the interface, with flat ground.
// SSBO 4 (std430) holds `octave_table(params, anchor_direction)` of systems/terrain/height.py.

struct TerrainPoint {
    float dh;         // height above the anchor's height H_a, metres
    vec3 gradient;    // surface gradient of the height at the foot: tangent vector in planet axes, metres per metre
    float roughness;  // multiplier of the fine layers: interpolate it, hand it to terrain_detail_gradient
    float moisture;   // 0 dry .. 1 wet, for materials
};

// Share of a layer in the gradient at a sample spacing: 0 below two samples per wavelength, 1 from four on.
float terrain_layer_weight(float wavelength_m, float spacing_m) {
    return smoothstep(2.0, 4.0, wavelength_m / spacing_m);
}

// D: the foot on the reference sphere minus the anchor's foot, metres, planet axes.
TerrainPoint terrain_point(vec3 D, float spacing_m) {
    return TerrainPoint(0.0, vec3(0.0), 0.0, 0.5);
}

// What terrain_point's gradient left out between the vertices' spacing and the pixel's footprint.
vec3 terrain_detail_gradient(vec3 D, float roughness, float spacing_vertex_m, float footprint_m) {
    return vec3(0.0);
}
