// The renderer's functions on an array of questions. A camera's tables are not stored here: each texel that a look-up
// reads is marched on the spot, by the code that fills the tables, and then interpolated by the code that reads them.
#include "atmosphere/source.glsl"
#include "atmosphere/irradiance.glsl"
#include "atmosphere/view.glsl"
#include "atmosphere/question.glsl"

AirView g_view;

AirColumn march(ivec3 texel) {
    float mu_s, nu;
    AirPath p = air_texel_path(g_view, texel.y, float(texel.x), mu_s, nu);
    AirColumn c = air_column(p.h, p.mu, mu_s, nu, p.length_m);
    int parts = air_slice_parts();
    for (int slice = 0; slice < texel.z * parts; ++slice) air_column_slice(c, slice, g_view.slices * parts);
    return c;
}

vec3 air_mean_extinction(ivec2 texel) {
    float mu_s, nu, t = 0.0;
    AirPath p = air_texel_path(g_view, texel.x, 0.0, mu_s, nu);
    vec3 depth = vec3(0.0);
    for (int slice = 0; slice < texel.y; ++slice) {
        depth += air_slice_depth(p.h, p.mu, p.length_m, p.lowest, p.split, slice, AIR_FINE * g_view.slices, t);
    }
    return air_pack(t > 0.0 ? depth / t : air_extinction(air_density(p.h)));
}

void air_texel(ivec2 texel, int layer, out vec3 first, out vec3 second) {
    int slice = min(layer, g_view.slices);
    AirColumn c = march(ivec3(texel, slice));
    air_start_means(c, first, second);
    if (slice > 0) {
        first = air_column_mean(c, c.first);
        second = air_column_mean(c, c.second);
    }
    if (layer == air_whole_layer(g_view)) {
        vec3 extinction = air_unpack(air_mean_extinction(ivec2(texel.y, AIR_FINE * g_view.slices)));
        first = air_whole_light(first, extinction, c.path);
        second = air_whole_light(second, extinction, c.path);
    } else {
        first = air_pack(first);
        second = air_pack(second);
    }
}

// The filter of the hardware, in full precision.
void air_light_at(AirView v, AirCell cell, int layer, out vec3 first, out vec3 second) {
    first = second = vec3(0.0);
    for (int k = 0; k < 4; ++k) {
        ivec2 corner_step = ivec2(k & 1, k >> 1);
        vec2 weight = mix(1.0 - cell.share, cell.share, vec2(corner_step));
        vec3 texel_first, texel_second;
        air_texel(cell.corner + corner_step, layer, texel_first, texel_second);
        first += weight.x * weight.y * texel_first;
        second += weight.x * weight.y * texel_second;
    }
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(u_count)) return;
    AirQuestion q = questions[i];
    g_view = AirView(q.altitude_m, q.sun_mu, q.sun_sine, q.floor_rays, q.open_rays, q.focus, u_size.x, u_size.y,
        u_size.z);
    air_orders = float(u_all_orders);
    AirRay ray = AirRay(q.mu, q.sine, q.azimuth, q.nu);
    vec3 transmittance = vec3(1.0), first = vec3(0.0), second = vec3(0.0);
    float path;
    if (u_asked == LIGHT) {
        if (q.distance_m < 0.0) {
            air_whole(g_view, ray, transmittance, first, second, path);
            if (!air_path(g_view, ray.mu, ray.sine).floor_hit) air_open(g_view, ray, first, second, path);
        } else air_between(g_view, ray, q.distance_m, transmittance, first, second, path);
        if (u_phase) first *= air_rayleigh_phase(ray.nu);
    } else if (u_asked == TO_SPACE) {
        AirPath p = air_path(g_view, ray.mu, ray.sine);
        bool open = !p.floor_hit;
        transmittance = p.length_m > 0.0 ? exp(-air_depth_to_space(p.h, p.mu)) : vec3(1.0);
        if (!open) transmittance = vec3(0.0);
    } else {
        float h = clamp(q.altitude_m, 0.0, air_model.thickness_m);
        first = air_sun_light(h, q.sun_mu, q.sun_cosine);
        if (q.altitude_m > air_model.thickness_m) {
            // From space the sun is seen past the air, through its limb, or not at all.
            AirPath p = air_path(g_view, q.sun_mu, q.sun_sine);
            vec3 through = p.length_m > 0.0 ? exp(-air_depth_to_space(p.h, p.mu)) : vec3(1.0);
            first = p.floor_hit ? vec3(0.0) : through * air_disc_cosine(q.sun_cosine, air_model.sun_radius_rad);
        }
        second = air_sky_light(h, q.sun_mu, q.n_up, q.n_side);
    }
    answer(i, transmittance, first, second, air_mie_phase(ray.nu));
}
