// Optical depth from a point of the air to space, from a table, and the sun's light there.
//
// The table holds the fourth root of the mean extinction along the path. x: length of the path between its least
// (straight up) and its most (along the horizon), by air_path_row; y: sqrt(h / thickness).
#include "generated/bindings.glsl"
#include "atmosphere/medium.glsl"

layout(binding = AIR_DEPTH_UNIT) uniform sampler2D u_air_depth;

// Optical depth of the whole ray from 0 <= h <= thickness; rays below the horizon get the horizon's.
vec3 air_depth_to_space(float h, float mu) {
    h = clamp(h, 0.0, air_model.thickness_m);
    float horizon2 = air_horizon2(h);
    float path = air_to_top(h, max(mu, -sqrt(horizon2) / (air_model.radius_m + h)));
    float least = air_model.thickness_m - h, range = sqrt(horizon2) + air_model.longest_path_m - least;
    ivec2 size = textureSize(u_air_depth, 0);
    float x = air_path_row(clamp((path - least) / range, 0.0, 1.0), 1.0) * float(size.x - 1);
    float y = sqrt(h * air_model.per_thickness) * float(size.y - 1);
    ivec2 corner = min(ivec2(x, y), size - 2);
    float fx = x - float(corner.x), fy = y - float(corner.y);
    // texelFetch: hardware filters with 8 bits.
    vec3 low = mix(texelFetch(u_air_depth, corner, 0).rgb, texelFetch(u_air_depth, corner + ivec2(1, 0), 0).rgb, fx);
    vec3 high = mix(
        texelFetch(u_air_depth, corner + ivec2(0, 1), 0).rgb, texelFetch(u_air_depth, corner + ivec2(1, 1), 0).rgb, fx);
    return path * air_unpack(mix(low, high, fy));
}

// Share of the sun's disc above the horizon, as common/sun_visibility.glsl has it (Bruneton 2017).
float air_sun_share(float h, float mu_s) {
    float soft = air_model.sun_radius_rad * air_model.radius_m / (air_model.radius_m + h);
    return smoothstep(-soft, soft, mu_s - air_horizon_cos(h));
}

// Transmittance towards the sun times the visible share of its disc.
vec3 air_sun(float h, float mu_s) {
    h = clamp(h, 0.0, air_model.thickness_m);
    return exp(-air_depth_to_space(h, mu_s)) * air_sun_share(h, mu_s);
}
