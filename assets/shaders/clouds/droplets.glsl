// What droplets do to light in one layer, whatever their density.
#include "clouds/layers.glsl"
#include "clouds/phase.glsl"

// Share of a layer's thickness below a height: 0 at its base, 1 at its top, and beyond.
float cloud_share(int layer, float h) {
    CloudModelLayer shell = cloud_model.layers[layer];
    return (h - shell.base_m) * shell.per_thickness;
}

// How dense the layer may be at that share of its height, 0..1 (Michelic 2018: a parabola); 0 outside.
float cloud_profile(int layer, float share) {
    float s = 2.0 * share - 1.0;
    float inside = share >= 0.0 && share <= 1.0 ? 1.0 : 0.0;
    return inside * (cloud_model.layers[layer].parabola ? max(1.0 - s * s, 0.0) : 1.0);
}
