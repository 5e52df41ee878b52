// The table of what depends on the altitude and the sun's height alone: irradiance of the sky (irradiance.glsl) in layers 0 to 3,
// moments of the light that has been scattered (moments.glsl) in those after them.
#include "atmosphere/medium.glsl"

layout(binding = 9) uniform sampler2DArray u_air_moments;

const int AIR_IRRADIANCE_LAYERS = 4;
const float AIR_SUN_FOCUS = 0.12;   // half of the nodes of mu_s lie where |mu_s| is below about this

// mu_s in -1..1 to 0..1, dense about the horizon.
float air_sun_row(float mu_s) {
    return 0.5 + 0.5 * (1.0 + AIR_SUN_FOCUS) * mu_s / (abs(mu_s) + AIR_SUN_FOCUS);
}

float air_sun_of_row(float row) {
    float v = (2.0 * row - 1.0) / (1.0 + AIR_SUN_FOCUS);
    return clamp(AIR_SUN_FOCUS * v / (1.0 - abs(v)), -1.0, 1.0);
}

// Where to look in the table.
struct AirPlace {
    ivec2 corner;
    vec2 share;
};

AirPlace air_place(float h, float mu_s) {
    ivec2 size = textureSize(u_air_moments, 0).xy;
    vec2 at = vec2(air_sun_row(mu_s), sqrt(clamp(h * air_model.radii.w, 0.0, 1.0))) * vec2(size - 1);
    AirPlace place;
    place.corner = clamp(ivec2(at), ivec2(0), size - 2);
    place.share = at - vec2(place.corner);
    return place;
}

vec3 air_moment(AirPlace p, int layer) {
    ivec3 c = ivec3(p.corner, layer);
    vec3 low = mix(texelFetch(u_air_moments, c, 0).rgb, texelFetch(u_air_moments, c + ivec3(1, 0, 0), 0).rgb, p.share.x);
    vec3 high = mix(texelFetch(u_air_moments, c + ivec3(0, 1, 0), 0).rgb,
        texelFetch(u_air_moments, c + ivec3(1, 1, 0), 0).rgb, p.share.x);
    return mix(low, high, p.share.y);
}
