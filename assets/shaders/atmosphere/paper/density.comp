// What is scattered at a point into a direction: the light of the order before, from 16 x 32 directions over the
// sphere, and that of the sunlit floor (Bruneton 2017). The sums are his; they are grouped so that fewer look-ups are
// needed. Along a cone of one zenith angle the table is linear between the layers of nu: so the phase functions are
// summed for each layer, and each layer is read once a cone, not twice a direction.
//
// FIRST_ORDER: the order before is single scattering, in two tables and without its phase functions.
// Stored: W m^-2 sr^-1 nm^-1 per thickness of the air, a unit that suits half floats on any planet.
#include "generated/bindings.glsl"
#include "common/constants.glsl"
#include "atmosphere/paper/transmittance.glsl"
#include "atmosphere/paper/medium.glsl"
#include "atmosphere/paper/slice.glsl"

layout(PAPER_FORMAT, binding = 0) writeonly uniform image3D u_density;
layout(binding = PAPER_MIE_UNIT) uniform sampler3D u_mie;
layout(binding = PAPER_BEFORE_UNIT) uniform sampler3D u_before;
layout(binding = PAPER_FLOOR_UNIT) uniform sampler2D u_floor_irradiance;

const int CONES = 16;
const int AROUND = 32;
const int QUADS = (PAPER_NU + 3) / 4;  // layers of nu by fours

// How much of a value belongs to each of four layers of nu.
vec4 layer_shares(float layer, int quad) {
    return max(1.0 - abs(layer - 4.0 * float(quad) - vec4(0.0, 1.0, 2.0, 3.0)), 0.0);
}

// A point of the air, its view and its sun. z is up, the view in the plane of x and z.
struct PaperPoint {
    float h, mu, mu_s;         // height; cosines of view and sun to the zenith
    float view_x, sun_x, sun_y;
    vec3 rayleigh, mie;        // scattering per metre
};

// Directions at one angle to the zenith.
struct Cone {
    float up, aside;           // cosine and sine of that angle
    bool hits_floor;
};

// How much of each layer of nu is scattered towards the view, summed around a cone. First letter: scattering of the
// order before, second: scattering here. Rayleigh or Mie.
struct ConeShares {
    vec4 to_rayleigh[QUADS], to_mie[QUADS];
#ifdef FIRST_ORDER
    vec4 mie_to_rayleigh[QUADS], mie_to_mie[QUADS];
#endif
};

// The next of AROUND directions.
vec2 turned(vec2 around, vec2 turn) {
    return vec2(around.x * turn.x - around.y * turn.y, around.x * turn.y + around.y * turn.x);
}

vec2 first_around() {
    return vec2(cos(PI / float(AROUND)), sin(PI / float(AROUND)));
}

vec2 turn_around() {
    return vec2(cos(2.0 * PI / float(AROUND)), sin(2.0 * PI / float(AROUND)));
}

// x: cosine between a direction of the cone and the sun; y: between it and the view.
vec2 cosines_of(PaperPoint p, Cone cone, vec2 around) {
    return vec2(clamp_cos(cone.aside * (around.x * p.sun_x + around.y * p.sun_y) + cone.up * p.mu_s),
        clamp_cos(cone.aside * around.x * p.view_x + cone.up * p.mu));
}

PaperPoint paper_point(PaperLayout layout_, ivec3 size, ivec3 texel) {
    PaperPoint p;
    float nu;
    bool unused;
    paper_scattering_texel(layout_, size, texel, p.h, p.mu, p.mu_s, nu, unused);
    vec3 density = paper_densities(p.h);
    p.rayleigh = air_model.rayleigh_per_m * density.x;
    p.mie = air_model.mie_scattering_per_m * density.y;
    p.view_x = sin_from_cos(p.mu);
    float sun_aside = sin_from_cos(p.mu_s);
    p.sun_x = clamp(p.view_x > 0.0 ? (nu - p.mu * p.mu_s) / p.view_x : 0.0, -sun_aside, sun_aside);
    p.sun_y = safe_sqrt((sun_aside - p.sun_x) * (sun_aside + p.sun_x));
    return p;
}

ConeShares cone_shares(PaperPoint p, Cone cone) {
    ConeShares s;
    for (int q = 0; q < QUADS; q++) {
        s.to_rayleigh[q] = s.to_mie[q] = vec4(0.0);
#ifdef FIRST_ORDER
        s.mie_to_rayleigh[q] = s.mie_to_mie[q] = vec4(0.0);
#endif
    }
    vec2 around = first_around(), turn = turn_around();
    for (int i = 0; i < AROUND; i++) {
        vec2 nu = cosines_of(p, cone, around);
        around = turned(around, turn);
        float layer = (0.5 * nu.x + 0.5) * float(PAPER_NU - 1);
        float by_rayleigh = paper_rayleigh_phase(nu.y), by_mie = paper_mie_phase(nu.y);
#ifdef FIRST_ORDER
        float rayleigh_before = paper_rayleigh_phase(nu.x), mie_before = paper_mie_phase(nu.x);
#endif
        for (int q = 0; q < QUADS; q++) {
            vec4 shares = layer_shares(layer, q);
#ifdef FIRST_ORDER
            s.mie_to_rayleigh[q] += shares * (mie_before * by_rayleigh);
            s.mie_to_mie[q] += shares * (mie_before * by_mie);
            shares *= rayleigh_before;
#endif
            s.to_rayleigh[q] += shares * by_rayleigh;
            s.to_mie[q] += shares * by_mie;
        }
    }
    return s;
}

// Light of the order before that comes along the cone through the air. sun: coordinate of the tables.
vec3 cone_light(PaperPoint p, Cone cone, ConeShares s, vec2 size, float sun) {
    vec2 view = paper_view_coordinates(p.h, cone.up, cone.hits_floor, size);
    vec3 sum = vec3(0.0);
    for (int q = 0; q < QUADS; q++) {
        for (int k = 0; k < 4; k++) {
            float layer = float(min(4 * q + k, PAPER_NU - 1));  // shares beyond the last layer are 0
            vec3 at = vec3((layer + sun) / float(PAPER_NU), view);
            vec3 before = textureLod(u_before, at, 0.0).rgb;
            sum += before * (s.to_rayleigh[q][k] * p.rayleigh + s.to_mie[q][k] * p.mie);
#ifdef FIRST_ORDER
            before = textureLod(u_mie, at, 0.0).rgb;
            sum += before * (s.mie_to_rayleigh[q][k] * p.rayleigh + s.mie_to_mie[q][k] * p.mie);
#endif
        }
    }
    return sum;
}

// And of the floor at its end. A loop without turns costs nothing where there is none.
vec3 floor_light(PaperPoint p, Cone cone) {
    int count = cone.hits_floor ? AROUND : 0;
    float to_floor = paper_distance_to_floor(p.h, cone.up);
    vec3 of_floor = paper_transmittance(p.h, cone.up, to_floor, cone.hits_floor) * air_model.ground_albedo / PI;
    vec3 sum = vec3(0.0);
    vec2 around = first_around(), turn = turn_around();
    for (int i = 0; i < count; i++) {
        vec2 nu = cosines_of(p, cone, around);
        around = turned(around, turn);
        float sun_there = paper_cosine_along(p.h, p.mu_s, to_floor * nu.x, 0.0);
        vec2 at = paper_irradiance_coordinates(0.0, sun_there, vec2(textureSize(u_floor_irradiance, 0)));
        sum += textureLod(u_floor_irradiance, at, 0.0).rgb
            * (paper_rayleigh_phase(nu.y) * p.rayleigh + paper_mie_phase(nu.y) * p.mie);
    }
    return of_floor * sum;
}

void main() {
    ivec3 texel;
    if (!paper_texel(texel)) {
        return;
    }
    ivec3 size = imageSize(u_density);
    PaperLayout layout_ = paper_layout();
    PaperPoint p = paper_point(layout_, size, texel);
    float sun = paper_coordinate(paper_sun_unit(p.mu_s, layout_.mu_s_min), float(size.x / PAPER_NU));
    vec3 sum = vec3(0.0);
    for (int k = 0; k < CONES; k++) {
        float theta = (float(k) + 0.5) * PI / float(CONES), up = cos(theta);
        Cone cone = Cone(up, sin(theta), paper_hits_floor(p.h, up));
        float solid_angle = 2.0 * PI * PI / float(CONES * AROUND) * cone.aside;
        vec3 light = cone_light(p, cone, cone_shares(p, cone), vec2(size.yz), sun);
        sum += (light + floor_light(p, cone)) * solid_angle;
    }
    imageStore(u_density, texel, vec4(paper_stored(sum * paper_thickness()), 0.0));
}
