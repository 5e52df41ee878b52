// The table of what depends on the altitude and the sun's height alone: irradiance of the sky (irradiance.glsl) in
// layers 0 to 3, moments of the light that has been scattered (moments.glsl) in those after them.
#include "generated/bindings.glsl"
#include "atmosphere/medium.glsl"

layout(binding = AIR_MOMENTS_UNIT) uniform sampler2DArray u_air_moments;

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

// Where to look in the table, 0..1.
struct AirPlace {
    vec2 at;
};

AirPlace air_place(float h, float mu_s) {
    vec2 size = vec2(textureSize(u_air_moments, 0).xy);
    vec2 at = vec2(air_sun_row(mu_s), sqrt(clamp(h * air_model.per_thickness, 0.0, 1.0)));
    return AirPlace((at * (size - 1.0) + 0.5) / size);
}

// Filtered by the hardware, with eight bits between neighbours: they are nearly equal.
vec3 air_moment(AirPlace p, int layer) {
    return textureLod(u_air_moments, vec3(p.at, float(layer)), 0.0).rgb;
}
