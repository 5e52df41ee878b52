// The renderer's own tables: what air_between and air_open read, and the ray of a direction at the camera.
#include "generated/bindings.glsl"
#include "common/camera.glsl"
#include "atmosphere/view.glsl"

layout(binding = AIR_FIRST_UNIT) uniform sampler2DArray u_air_first;
layout(binding = AIR_SECOND_UNIT) uniform sampler2DArray u_air_second;
layout(binding = AIR_EXTINCTION_UNIT) uniform sampler2D u_air_extinction;

// Filtered by the hardware: eight bits between neighbours that differ by a few percent. Extinction is not, it needs
// more.
void air_light_at(AirView v, AirCell cell, int layer, out vec3 first, out vec3 second) {
    vec3 at = vec3((vec2(cell.corner) + cell.share + 0.5) / vec2(v.columns, 2 * v.rows), layer);
    first = textureLod(u_air_first, at, 0.0).rgb;
    second = textureLod(u_air_second, at, 0.0).rgb;
}

vec3 air_mean_extinction(ivec2 texel) {
    return texelFetch(u_air_extinction, texel, 0).rgb;
}

AirRay air_ray(vec3 direction) {
    vec3 up = frame.camera_zenith;
    AirRay ray;
    ray.mu = clamp_cos(dot(direction, up));
    ray.sine = length(direction - up * dot(direction, up));
    // Straight up and down there is no azimuth, and none matters.
    ray.azimuth = clamp_cos(dot(direction, air_view.sun_side) / max(ray.sine, 1e-9));
    ray.nu = clamp_cos(dot(direction, frame.sun_direction));
    return ray;
}

// Sunlight scattered by air of a path's length, and the faint glow of the air itself.
vec3 air_radiance(AirRay ray, vec3 first, vec3 second, float path) {
    return frame.sun_irradiance * (air_rayleigh_phase(ray.nu) * first + air_mie_phase(ray.nu) * second)
        + air_model.night_radiance * (path * air_model.per_thickness);
}
