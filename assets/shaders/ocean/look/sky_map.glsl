// The sky over the camera as a square map, for the many directions that a sea mirrors: an octahedron's upper half,
// turned by 45 degrees so that the horizon is the map's border, where texels crowd: the sky changes most there.
#include "generated/frame.glsl"

const int SKY_MAP_SIDE = 64;   // systems/ocean/shading.py

mat3 sky_map_axes() {
    vec3 zenith = frame.camera_zenith, helper = abs(zenith.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0);
    vec3 side = normalize(cross(helper, zenith));
    return mat3(side, cross(zenith, side), zenith);
}

// Texture coordinates of a direction; below the horizon the horizon's.
vec2 sky_map_place(vec3 direction) {
    vec3 d = direction * sky_map_axes();
    vec2 p = d.xy / max(abs(d.x) + abs(d.y) + max(d.z, 0.0), 1e-6);
    vec2 square = vec2(p.x + p.y, p.x - p.y);
    float r = max(max(abs(square.x), abs(square.y)), 1e-6);
    square *= (1.0 - sqrt(max(1.0 - r, 0.0))) / r;
    return (square * (0.5 * float(SKY_MAP_SIDE - 1)) + 0.5 * float(SKY_MAP_SIDE)) / float(SKY_MAP_SIDE);
}

vec3 sky_map_direction(ivec2 texel) {
    vec2 square = vec2(2 * texel - (SKY_MAP_SIDE - 1)) / float(SKY_MAP_SIDE - 1);
    float r = max(max(abs(square.x), abs(square.y)), 1e-6), left = 1.0 - r;
    square *= (1.0 - left * left) / r;
    vec2 p = 0.5 * vec2(square.x + square.y, square.x - square.y);
    return sky_map_axes() * normalize(vec3(p, 1.0 - abs(p.x) - abs(p.y)));
}
