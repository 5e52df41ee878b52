// Contract "air_point" (common/air_point.glsl has the rules), from the tables that hold for all cameras.
#include "atmosphere/sunlight.glsl"
#include "atmosphere/moments.glsl"

struct AirPoint {
    vec3 extinction, sun_depth, direct, diffuse, ambient;
};

AirPoint air_point(float h, float mu, float mu_s, float nu, float scattered_before) {
    vec3 density = air_density(h), none = vec3(0.0);
    AirPoint at = AirPoint(air_extinction(density), air_depth_to_space(h, mu_s), none, none, none);
    at.direct = density.x * air_rayleigh_phase(nu) * air_model.rayleigh_per_m
        + density.y * air_mie_phase(nu) * air_model.mie_scattering_per_m;
    if (scattered_before > 0.0) {
        at.diffuse = air_multiple(air_folded(h, mu, mu_s, nu), density);
        // The first moment is the mean radiance.
        at.ambient = air_unpack(air_moment(air_place(h, mu_s), AIR_IRRADIANCE_LAYERS));
    }
    return at;
}
