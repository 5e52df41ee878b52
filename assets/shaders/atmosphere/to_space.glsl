// air_to_space() of the contract "air" (common/air.glsl has the rules).
#include "common/camera.glsl"
#include "atmosphere/sunlight.glsl"

vec3 air_to_space(vec3 from, vec3 direction) {
    float h = altitude_of(from);
    vec3 up = up_at(from);
    float mu = clamp_cos(dot(direction, up));
    if (h > air_model.radii.z) {
        float miss = (air_model.radii.x + h) * length(direction - up * mu);
        float inside2 = (air_model.radii.y - miss) * (air_model.radii.y + miss);
        if (mu >= 0.0 || inside2 <= 0.0) return vec3(1.0);
        h = air_model.radii.z;
        mu = -sqrt(inside2) / air_model.radii.y;
    }
    return exp(-air_depth_to_space(h, mu));
}
