// One order of scattering: the light that arrives at each point (mu_s, h) of the table from a share of all directions,
// added to its moments and to its irradiance. Light of order 1 was scattered once in the air, or once by the ground.
//
// A column of invocations is one altitude, a lane one height of the sun. Directions: u_directions pairs of (cosine to
// the zenith, weight) come from Gauss rules above and below the horizon, made for each altitude; azimuths are midpoints
// over half a circle.
#include "generated/bindings.glsl"
#include "common/constants.glsl"
#include "atmosphere/sunlight.glsl"
#include "atmosphere/moments.glsl"
#include "atmosphere/irradiance.glsl"
#include "atmosphere/column.glsl"

layout(local_size_x = 8) in;
layout(rgba32f, binding = 0) uniform image2DArray u_sums;

layout(location = 0) uniform int u_first_row;    // of altitudes
layout(location = 1) uniform ivec2 u_directions; // the first, and the one after the last
layout(location = 2) uniform int u_above;        // directions above the horizon
layout(location = 3) uniform int u_azimuths;
layout(location = 4) uniform int u_slices;
// Of the Gauss rules on 0..1, above the horizon and below it.
struct Node {
    float above, above_weight, below, below_weight;
};
layout(std140, binding = AIR_NODES_BLOCK) uniform Nodes { Node nodes[32]; };

AirFolded air_before = AirFolded(vec3(0.0), vec3(0.0));   // in the slice at hand

void column_middle(float h, float mu, float mu_s, float nu) {
    if (GATHER_FIRST == 0) air_before = air_folded(h, mu, mu_s, nu);
}

void column_source(float h, float mu, float mu_s, float nu, vec3 density, out vec3 first, out vec3 second) {
    if (GATHER_FIRST == 1) {
        vec3 scattered = density.x * air_model.rayleigh_per_m * air_rayleigh_phase(nu)
            + density.y * air_model.mie_scattering_per_m * air_mie_phase(nu);
        first = scattered * air_sun(h, mu_s);
    } else {
        first = air_multiple(air_before, density);
    }
    second = vec3(0.0);
}

// Light that the ground throws back, having got it by way of the last order.
vec3 ground_light(float mu_s) {
    vec3 irradiance = GATHER_FIRST == 1 ? air_sun(0.0, mu_s) * max(mu_s, 0.0) : air_irradiance_at(0.0, mu_s).up;
    return air_model.ground_albedo / PI * irradiance;
}

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, u_first_row), size = imageSize(u_sums).xy;
    if (texel.x >= size.x || texel.y >= size.y) return;
    vec2 at = vec2(texel) / vec2(size - 1);
    float h = at.y * at.y * air_model.thickness_m;
    float mu_s = air_sun_of_row(at.x), sine_s = sin_from_cos(mu_s), horizon = air_horizon_cos(h);
    int slices = u_slices * air_slice_parts();
    vec3 sums[AIR_MOMENTS + AIR_IRRADIANCE_LAYERS];
    for (int i = 0; i < AIR_MOMENTS + AIR_IRRADIANCE_LAYERS; ++i) sums[i] = imageLoad(u_sums, ivec3(texel, i)).rgb;

    for (int d = u_directions.x; d < u_directions.y; ++d) {
        int zenith = d / u_azimuths;
        bool above = zenith < u_above;
        Node node = nodes[above ? zenith : zenith - u_above];
        // Squares of the nodes: directions crowd at the horizon on both sides, where the air is bright.
        float x = above ? node.above : node.below, reach = above ? 1.0 - horizon : 1.0 + horizon;
        float mu = above ? horizon + reach * x * x : horizon - reach * x * x;
        float weight = above ? node.above_weight : node.below_weight;
        weight = 2.0 * x * reach * weight * (2.0 * PI / float(u_azimuths));
        float phi = (float(d - zenith * u_azimuths) + 0.5) * PI / float(u_azimuths);
        float sine = sin_from_cos(mu), cosine = cos(phi);
        float nu = clamp_cos(mu * mu_s + sine * sine_s * cosine);
        float to_floor = air_to_floor(h, mu);
        float path = above || to_floor < 0.0 ? air_to_top(h, max(mu, horizon)) : to_floor;

        AirColumn c = air_column(h, mu, mu_s, nu, path);
        for (int slice = 0; slice < slices; ++slice) air_column_slice(c, slice, slices);
        float mu_s_hit = clamp_cos(((air_model.radius_m + h) * mu_s + path * nu) / air_model.radius_m);
        // The mean source over what the air takes: right in thick air too, where two points in a slice are few.
        vec3 through = exp(-c.depth);
        vec3 light = air_column_mean(c, c.first) * air_taken(c.depth, through);
        light = weight * (light + (above ? vec3(0.0) : ground_light(mu_s_hit) * through));

        float diagonal = 1.0, turn = 1.0, turn_last = 0.0;
        for (int m = 0; m <= AIR_DEGREE; ++m) {
            float p = diagonal, p_last = 0.0;
            for (int l = m; l <= AIR_DEGREE; ++l) {
                sums[AIR_IRRADIANCE_LAYERS + l * (l + 1) / 2 + m] += light * (p * turn);
                float p_next = (float(2 * l + 1) * mu * p - float(l + m) * p_last) / float(l + 1 - m);
                p_last = p;
                p = p_next;
            }
            diagonal *= float(2 * m + 1) * sine;
            float turn_next = m == 0 ? cosine : 2.0 * cosine * turn - turn_last;
            turn_last = turn;
            turn = turn_next;
        }
        if (above) {
            sums[0] += light * max(mu, 0.0);
            sums[1] += light * (sine * max(cosine, 0.0));
            sums[2] += light * (sine * max(-cosine, 0.0));
            sums[3] += light * (sine * 0.5 * sin(phi));
        }
    }
    for (int i = 0; i < AIR_MOMENTS + AIR_IRRADIANCE_LAYERS; ++i)
        imageStore(u_sums, ivec3(texel, i), vec4(sums[i], 0.0));
}
