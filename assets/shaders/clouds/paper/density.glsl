// The printed density of clouds (Michelic 2018, equations 12 to 14): one volume, repeated over the planet.
//
//   float paper_density(vec3 place, float altitude, float level)
//                                below 0: empty, and far from cloud; 0: empty, next to it; up to 1
//   float paper_level(float distance_m)          the texture's mip level
//
// place: metres from the anchor in planet axes. Of cloud_view it reads layers[0], turn and broad.
#include "generated/bindings.glsl"
#include "common/camera.glsl"
#include "generated/cloud_view.glsl"

layout(binding = CLOUD_TILE_UNIT) uniform sampler3D u_cloud_tile;

// A linear filter spreads a texel over two: texels are half as wide as a pixel. Ones wider than two thicknesses of the
// layer would mix what lies above and below it into all clouds, an even veil; from so far away each pixel has its own
// place in the clouds, as all have in the source, which knows no levels.
float paper_level(float distance_m) {
    float texels_per_m = cloud_view.broad.per_m * float(textureSize(u_cloud_tile, 0).x);
    float texel_m = min(0.5 * distance_m * frame.pixel_rad, 2.0 / cloud_view.layers[0].per_thickness);
    return log2(max(texel_m * texels_per_m, 1.0));
}

float paper_density(vec3 place, float altitude, float level) {
    vec3 turned = cloud_view.turn * place;
    float tex = textureLod(u_cloud_tile, cloud_view.broad.origin + turned * cloud_view.broad.per_m, level).r;
    CloudViewLayer shell = cloud_view.layers[0];
    float s = 2.0 * clamp((altitude - shell.base_m) * shell.per_thickness, 0.0, 1.0) - 1.0;
    return tex < 0.0 ? -1.0 : (1.0 - shell.parabola * s * s) * tex;
}

// Distance from a place at an altitude to a height above it, along a direction of cosine mu to the zenith.
float paper_rise(float altitude, float mu, float height) {
    float rise = max(height - altitude, 0.0), r = planet.radius_m + altitude, b = r * mu, c = rise * (2.0 * r + rise);
    float root = sqrt(max(b * b + c, 0.0));
    return b >= 0.0 ? c / max(root + b, 1e-6) : root - b;
}
