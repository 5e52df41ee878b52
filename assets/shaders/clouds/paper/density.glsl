// The printed density of clouds (Michelic 2018, equations 12 to 14): one volume, repeated over the planet.
//
//   float paper_density(vec3 place, float altitude, float level)
//                                below 0: empty, and far from cloud; 0: empty, next to it; up to 1
//   float paper_level(float distance_m)          the texture's mip level whose texels are as wide as a pixel
//
// place: metres from the anchor in planet axes. Of cloud_view it reads layers[0], turn and broad.
#include "generated/bindings.glsl"
#include "common/camera.glsl"
#include "generated/cloud_view.glsl"

layout(binding = CLOUD_TILE_UNIT) uniform sampler3D u_cloud_tile;

float paper_level(float distance_m) {
    float texels = distance_m * frame.pixel_rad * cloud_view.broad.per_m * float(textureSize(u_cloud_tile, 0).x);
    return log2(max(texels, 1.0));
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
