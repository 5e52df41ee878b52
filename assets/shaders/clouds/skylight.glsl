// Contract "skylight" (common/skylight.glsl has the rules): light of the sky above the clouds that comes through them,
// and sunlight that they have scattered, which is as white as the sunlight above them.
#include "common/planet_shadow.glsl"
#include "clouds/shadow.glsl"
#include "contract/air.glsl"
#include "contract/sky.glsl"

vec3 skylight(vec3 point, vec3 normal) {
    float altitude = altitude_of(point);
    vec3 up = up_at(point), sun = frame.sun_direction;
    float mu_s = dot(up, sun), n_up = dot(normal, up), rise = max(cloud_view.highest_m - altitude, 0.0);
    // From half of the sky the light comes from clouds within their height to all sides.
    vec4 through = mix(vec4(1.0, 0.0, 1.0, 0.0), slab_transmittance_at(point, altitude, 2.0 * rise),
        cloud_view.surface_skylight);
    vec3 top = point + up * rise;
    float above = sun_visibility_of_sphere(altitude + rise, mu_s, frame.sun_radius_rad) * max(mu_s, 0.0);
    vec3 scattered = frame.sun_irradiance * air_to_space(top, sun) * (above * through.y);
    return through.z * sky_irradiance(point, normal) + scattered * (0.5 + 0.5 * n_up);
}
