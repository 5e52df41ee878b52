// Reads the transmittance table. Its unused fourth channel says how the scattering tables are laid out, so that tables
// of any size can be bound to a program without building it again.
#include "generated/bindings.glsl"
#include "atmosphere/paper/mapping.glsl"

layout(binding = PAPER_TRANSMITTANCE_UNIT) uniform sampler2D u_air_transmittance;

PaperLayout paper_layout() {
    PaperLayout found;
    found.nu_size = max(texelFetch(u_air_transmittance, ivec2(0, 0), 0).a, 2.0);
    found.mu_s_min = texelFetch(u_air_transmittance, ivec2(1, 0), 0).a;
    return found;
}

// From altitude h to the top, of a ray that does not hit the floor.
vec3 paper_transmittance_to_top(float h, float mu) {
    vec2 unit = paper_transmittance_unit(h, mu);
    vec2 size = vec2(textureSize(u_air_transmittance, 0));
    return textureLod(u_air_transmittance, (0.5 + unit * (size - 1.0)) / size, 0.0).rgb;
}

// Of the first `distance_m` of a ray: the quotient of two look-ups. Air so thick that both are 0 lets nothing through.
vec3 paper_transmittance(float h, float mu, float distance_m, bool hits_floor) {
    float h_there = paper_altitude_along(h, mu, distance_m);
    float mu_there = paper_cosine_along(h, mu, distance_m, h_there);
    vec3 upper = hits_floor ? paper_transmittance_to_top(h, -mu) : paper_transmittance_to_top(h_there, mu_there);
    vec3 lower = hits_floor ? paper_transmittance_to_top(h_there, -mu_there) : paper_transmittance_to_top(h, mu);
    return min(lower / max(upper, vec3(1e-37)), vec3(1.0));
}

// To the sun, times the share of its disc above the horizon. h inside the shell.
vec3 paper_sun_transmittance(float h, float mu_s) {
    float horizon = paper_horizon(h);
    float soft = max(air_model.sun_radius_rad * air_model.radius_m / paper_radius(h), 1e-7);
    return paper_transmittance_to_top(h, max(mu_s, horizon)) * smoothstep(-soft, soft, mu_s - horizon);
}
