// What is scattered at a point into a direction: the light of the order before, from 16 x 32 directions over the
// sphere, and that of the sunlit floor (Bruneton 2017). The sums are his; they are grouped so that fewer look-ups are
// needed. Along a cone of one zenith angle the table is linear between the layers of nu: so the phase functions are
// summed for each layer, and each layer is read once a cone, not twice a direction.
//
// FIRST_ORDER: the order before is single scattering, in two tables and without its phase functions.
// Stored: W m^-2 sr^-1 nm^-1 per thickness of the air, a unit that suits half floats on any planet.
#include "generated/bindings.glsl"
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

void main() {
    ivec3 texel;
    if (!paper_texel(texel)) {
        return;
    }
    ivec3 size = imageSize(u_density);
    PaperLayout layout_ = paper_layout();
    float h, mu, mu_s, nu;
    bool unused;
    paper_scattering_texel(layout_, size, texel, h, mu, mu_s, nu, unused);
    vec3 density = paper_densities(h);
    vec3 rayleigh_here = air_model.rayleigh_per_m * density.x;
    vec3 mie_here = air_model.mie_scattering_per_m * density.y;

    // z is up, the view in the plane of x and z.
    float view_x = sin_from_cos(mu);
    float sun_aside = sin_from_cos(mu_s);
    float sun_x = clamp(view_x > 0.0 ? (nu - mu * mu_s) / view_x : 0.0, -sun_aside, sun_aside);
    float sun_y = safe_sqrt((sun_aside - sun_x) * (sun_aside + sun_x));
    float sun_coordinate = paper_coordinate(paper_sun_unit(mu_s, layout_.mu_s_min), float(size.x / PAPER_NU));
    vec2 turn = vec2(cos(2.0 * PF_PI / float(AROUND)), sin(2.0 * PF_PI / float(AROUND)));
    vec2 start = vec2(cos(PF_PI / float(AROUND)), sin(PF_PI / float(AROUND)));

    vec3 sum = vec3(0.0);
    for (int cone = 0; cone < CONES; cone++) {
        float theta = (float(cone) + 0.5) * PF_PI / float(CONES);
        float up = cos(theta);
        float aside = sin(theta);
        float solid_angle = 2.0 * PF_PI * PF_PI / float(CONES * AROUND) * aside;
        bool hits_floor = paper_hits_floor(h, up);

        // First letter: scattering of the order before, second: scattering here. Rayleigh or Mie.
        vec4 to_rayleigh[QUADS], to_mie[QUADS];
#ifdef FIRST_ORDER
        vec4 mie_to_rayleigh[QUADS], mie_to_mie[QUADS];
#endif
        for (int q = 0; q < QUADS; q++) {
            to_rayleigh[q] = to_mie[q] = vec4(0.0);
#ifdef FIRST_ORDER
            mie_to_rayleigh[q] = mie_to_mie[q] = vec4(0.0);
#endif
        }
        vec2 around = start;
        for (int i = 0; i < AROUND; i++) {
            float nu_before = clamp_cos(aside * (around.x * sun_x + around.y * sun_y) + up * mu_s);
            float nu_here = clamp_cos(aside * around.x * view_x + up * mu);
            around = vec2(around.x * turn.x - around.y * turn.y, around.x * turn.y + around.y * turn.x);
            float layer = (0.5 * nu_before + 0.5) * float(PAPER_NU - 1);
            float by_rayleigh = paper_rayleigh_phase(nu_here);
            float by_mie = paper_mie_phase(nu_here);
#ifdef FIRST_ORDER
            float rayleigh_before = paper_rayleigh_phase(nu_before);
            float mie_before = paper_mie_phase(nu_before);
#endif
            for (int q = 0; q < QUADS; q++) {
                vec4 shares = layer_shares(layer, q);
#ifdef FIRST_ORDER
                mie_to_rayleigh[q] += shares * (mie_before * by_rayleigh);
                mie_to_mie[q] += shares * (mie_before * by_mie);
                shares *= rayleigh_before;
#endif
                to_rayleigh[q] += shares * by_rayleigh;
                to_mie[q] += shares * by_mie;
            }
        }
        vec2 view = paper_view_coordinates(h, up, hits_floor, vec2(size.yz));
        vec3 cone_sum = vec3(0.0);
        for (int q = 0; q < QUADS; q++) {
            for (int k = 0; k < 4; k++) {
                float layer = float(min(4 * q + k, PAPER_NU - 1));  // shares beyond the last layer are 0
                vec3 at = vec3((layer + sun_coordinate) / float(PAPER_NU), view);
                vec3 before = textureLod(u_before, at, 0.0).rgb;
                cone_sum += before * (to_rayleigh[q][k] * rayleigh_here + to_mie[q][k] * mie_here);
#ifdef FIRST_ORDER
                before = textureLod(u_mie, at, 0.0).rgb;
                cone_sum += before * (mie_to_rayleigh[q][k] * rayleigh_here + mie_to_mie[q][k] * mie_here);
#endif
            }
        }

        // The floor at the end of the cone. A loop without turns costs nothing where there is none.
        int around_floor = hits_floor ? AROUND : 0;
        float to_floor = paper_distance_to_floor(h, up);
        vec3 of_floor = paper_transmittance(h, up, to_floor, hits_floor) * air_model.ground_albedo / PF_PI;
        vec3 floor_sum = vec3(0.0);
        around = start;
        for (int i = 0; i < around_floor; i++) {
            float nu_before = clamp_cos(aside * (around.x * sun_x + around.y * sun_y) + up * mu_s);
            float nu_here = clamp_cos(aside * around.x * view_x + up * mu);
            around = vec2(around.x * turn.x - around.y * turn.y, around.x * turn.y + around.y * turn.x);
            float sun_there = paper_cosine_along(h, mu_s, to_floor * nu_before, 0.0);
            vec2 at = paper_irradiance_coordinates(0.0, sun_there, vec2(textureSize(u_floor_irradiance, 0)));
            floor_sum += textureLod(u_floor_irradiance, at, 0.0).rgb
                * (paper_rayleigh_phase(nu_here) * rayleigh_here + paper_mie_phase(nu_here) * mie_here);
        }
        sum += (cone_sum + of_floor * floor_sum) * solid_angle;
    }
    imageStore(u_density, texel, vec4(paper_stored(sum * paper_thickness()), 0.0));
}
