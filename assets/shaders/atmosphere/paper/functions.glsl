// The air of one planet from precomputed tables: Bruneton and Neyret 2008 in the form of Bruneton 2017, for a unit sun.
//
// h: altitude above the floor in metres, of any value: below the floor it is held at 0, above the top the camera is in
// space and its ray begins where it enters the air. mu, mu_s: cosines of the angles from the zenith to the view and to
// the sun, nu: cosine between these two. Radiance 0 and transmittance 1 for a ray that misses the air.
//
// f32 cosines tell rays apart to about 1e-7 of a radian's square: from more than some hundred planet radii away let the
// caller find the entry point in double precision and ask there.
//
// The method's own faults are kept, it is here to compare with: air_segment can be negative or striped where its two
// look-ups nearly cancel, notably after sunset; the sun's axis ends at an angle beyond which the night glows; eight
// layers of nu are coarse at dusk; the sun's axis of the irradiance is linear; the sums end with the given order.
#include "generated/bindings.glsl"
#include "atmosphere/paper/transmittance.glsl"
#include "atmosphere/paper/medium.glsl"

layout(binding = PAPER_SCATTERING_UNIT) uniform sampler3D u_air_scattering;
layout(binding = PAPER_MIE_UNIT) uniform sampler3D u_air_mie;
layout(binding = PAPER_IRRADIANCE_UNIT) uniform sampler2D u_air_irradiance;

// Both scattering tables at a place inside the shell, without phase functions.
void paper_read_scattering(float h, float mu, float mu_s, float nu, bool hits_floor, out vec3 scattering,
    out vec3 mie) {
    ivec3 size = textureSize(u_air_scattering, 0);
    PaperPlace place = paper_scattering_place(paper_layout(), size, h, mu, mu_s, nu, hits_floor);
    scattering = mix(
        textureLod(u_air_scattering, place.first, 0.0).rgb, textureLod(u_air_scattering, place.second, 0.0).rgb,
            place.blend
    );
    mie = mix(textureLod(u_air_mie, place.first, 0.0).rgb, textureLod(u_air_mie, place.second, 0.0).rgb, place.blend);
}

// Transmittance of a ray to space; 0 where it hits the floor.
vec3 air_transmittance_to_space(float h, float mu) {
    float mu_s = 0.0, distance_m;
    if (!paper_enter(h, mu, mu_s, 0.0, distance_m)) {
        return vec3(1.0);
    }
    return paper_hits_floor(h, mu) ? vec3(0.0) : paper_transmittance_to_top(h, mu);
}

// Transmittance to the sun, times the share of its disc above the horizon of the floor.
vec3 air_sun_transmittance(float h, float mu_s) {
    float tangent = paper_tangent(max(h, 0.0));
    float r = paper_radius(max(h, 0.0));
    float horizon = -tangent / r;
    float soft = max(air_model.sun_radius_rad * air_model.radius_m / r, 1e-7);
    float visible = smoothstep(-soft, soft, mu_s - horizon);
    float mu = max(mu_s, horizon), unused = 0.0, distance_m;
    bool inside = paper_enter(h, mu, unused, 0.0, distance_m);
    vec3 through = paper_transmittance_to_top(min(h, paper_thickness()),
        max(mu, paper_horizon(min(h, paper_thickness()))));
    return (inside ? through : vec3(1.0)) * visible;
}

// Light of the sky along a ray. rayleigh_and_multiple: single scattering by molecules and all higher orders, times the
// Rayleigh phase function; mie: single scattering by aerosols, without its phase function. transmittance: to space.
void air_sky(
    float h, float mu, float mu_s, float nu, out vec3 rayleigh_and_multiple, out vec3 mie, out vec3 transmittance
) {
    float distance_m;
    bool inside = paper_enter(h, mu, mu_s, nu, distance_m);
    h = min(h, paper_thickness());
    bool hits_floor = paper_hits_floor(h, mu);
    vec3 scattering;
    paper_read_scattering(h, mu, mu_s, nu, hits_floor, scattering, mie);
    rayleigh_and_multiple = inside ? scattering * paper_rayleigh_phase(nu) : vec3(0.0);
    mie = inside ? mie : vec3(0.0);
    transmittance = !inside ? vec3(1.0) : hits_floor ? vec3(0.0) : paper_transmittance_to_top(h, mu);
}

vec3 air_sky_radiance(float h, float mu, float mu_s, float nu) {
    vec3 rest, mie, transmittance;
    air_sky(h, mu, mu_s, nu, rest, mie, transmittance);
    return rest + mie * paper_mie_phase(nu);
}

// What the air does along the first `distance_m` of a ray, by subtracting what lies beyond from what lies ahead. Light
// of aerosols is faded out when the sun is down at the camera, as the source does against its worst artefacts.
void air_segment(
    float h, float mu, float mu_s, float nu, float distance_m, out vec3 transmittance, out vec3 in_scatter
) {
    float skipped_m;
    bool inside = paper_enter(h, mu, mu_s, nu, skipped_m);
    h = min(h, paper_thickness());
    bool hits_floor = paper_hits_floor(h, mu);
    float along = min(distance_m - skipped_m, paper_distance_to_boundary(h, mu, hits_floor));
    inside = inside && along > 0.0;
    along = max(along, 0.0);

    vec3 ahead, mie_ahead, beyond, mie_beyond;
    paper_read_scattering(h, mu, mu_s, nu, hits_floor, ahead, mie_ahead);
    float h_there = paper_altitude_along(h, mu, along);
    float mu_there = paper_cosine_along(h, mu, along, h_there);
    float sun_there = paper_cosine_along(h, mu_s, along * nu, h_there);
    paper_read_scattering(h_there, mu_there, sun_there, nu, hits_floor, beyond, mie_beyond);

    transmittance = inside ? paper_transmittance(h, mu, along, hits_floor) : vec3(1.0);
    vec3 mie = (mie_ahead - transmittance * mie_beyond) * smoothstep(0.0, 0.01, mu_s);
    vec3 found = (ahead - transmittance * beyond) * paper_rayleigh_phase(nu) + mie * paper_mie_phase(nu);
    in_scatter = inside ? found : vec3(0.0);
}

// Irradiance of a surface by the sky; up_dot_normal: cosine between the zenith and its normal.
vec3 air_sky_irradiance(float h, float mu_s, float up_dot_normal) {
    vec2 at = paper_irradiance_coordinates(h, clamp_cos(mu_s), vec2(textureSize(u_air_irradiance, 0)));
    return textureLod(u_air_irradiance, at, 0.0).rgb * (0.5 + 0.5 * clamp_cos(up_dot_normal));
}
