// air_to_space() of the contract "air" (common/air.glsl has the rules).
#include "common/camera.glsl"
#include "atmosphere/sunlight.glsl"

vec3 air_to_space(vec3 from, vec3 direction) {
    float h = altitude_of(from);
    vec3 up = up_at(from);
    float mu = clamp_cos(dot(direction, up));
    if (h > air_model.thickness_m) {
        float miss = (air_model.radius_m + h) * length(direction - up * mu);
        float inside2 = (air_model.top_radius_m - miss) * (air_model.top_radius_m + miss);
        if (mu >= 0.0 || inside2 <= 0.0) return vec3(1.0);
        h = air_model.thickness_m;
        mu = -sqrt(inside2) / air_model.top_radius_m;
    }
    return exp(-air_depth_to_space(h, mu));
}
