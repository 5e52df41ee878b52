// Light of the whole sky on a surface, all orders, W m^-2 nm^-1 per unit of the sun's: light from every direction that
// does not end on the ground. Four layers of the table: what faces up and upright walls facing the sun, away from it
// and at right angles to it get together (fourth root), and the shares of the first three. Ratios to what faces up
// alone would be infinite at the top of the air, where no sky is above and some lies beside.
#include "atmosphere/sunlight.glsl"
#include "atmosphere/table.glsl"

struct AirIrradiance {
    vec3 up, sunward, sideways, away;
};

AirIrradiance air_irradiance_at(float h, float mu_s) {
    AirPlace place = air_place(h, mu_s);
    vec3 together = air_unpack(air_moment(place, 0));
    vec3 up = air_moment(place, 1), sunward = air_moment(place, 2), away = air_moment(place, 3);
    vec3 sideways = max(1.0 - up - sunward - away, 0.0);
    return AirIrradiance(together * up, together * sunward, together * sideways, together * away);
}

// n_up: cosine of the normal to the zenith; n_side: its component towards the sun's azimuth (both of a unit normal).
// Exact facing up and for upright walls in the three azimuths. In between, the mean over azimuths of a uniform sky is
// linear in n_up; a sky that is brighter at its horizon, as walls show, bulges above that line by 0.36 of (walls - 1/2)
// times the sine of twice the tilt, and facing down sees a bright rim: both fitted to Monte-Carlo with suns at 30 to 92
// degrees, at the ground and at 10 km. Slopes in single azimuths are then within 9 % of it, surfaces that face down
// within 20 %.
vec3 air_sky_light(float h, float mu_s, float n_up, float n_side) {
    AirIrradiance e = air_irradiance_at(h, mu_s);
    vec3 linear = 0.5 * (e.sunward - e.away);
    vec3 even = 0.25 * (e.sunward + e.away) + 0.5 * e.sideways;
    vec3 twofold = 0.25 * (e.sunward + e.away) - 0.5 * e.sideways;
    float flat2 = max(1.0 - n_up * n_up, 0.0), level = sqrt(flat2);
    vec3 bright = even - 0.5 * e.up;
    vec3 raised = even + (e.up - even) * n_up + bright * (0.72 * level * n_up);
    vec3 rim = max(bright / max(even + 0.06 * e.up, 1e-30), 0.0);
    vec3 share = (1.0 + n_up) / max(1.0 + n_up * rim, 1e-3);
    vec3 sideward = linear * n_side + twofold * (2.0 * n_side * n_side - flat2);
    return max(n_up < 0.0 ? share * (even + sideward / max(level, 1e-2)) : raised + sideward, 0.0);
}

// Mean cosine of the sun's disc to a surface, its parts behind the surface counted as 0: a disc whose points are even
// in their cosine (Bruneton 2017, direct irradiance). `cosine` is that of its middle.
float air_disc_cosine(float cosine, float radius) {
    float rising = cosine + radius;
    return cosine >= radius ? cosine : cosine <= -radius ? 0.0 : rising * rising / (4.0 * radius);
}

// The sun's own light on a surface, cosine included. What the planet hides of the disc, a level surface doesn't face
// anyway: only what is hidden beyond that counts.
vec3 air_sun_light(float h, float mu_s, float cosine) {
    float radius = air_model.sun_radius_rad;
    float facing = smoothstep(-radius, radius, cosine);
    float left = min(air_sun_share(h, mu_s) / max(facing, 1e-6), 1.0);
    return exp(-air_depth_to_space(h, mu_s)) * (air_disc_cosine(cosine, radius) * left);
}
