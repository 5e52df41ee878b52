// Light that the air does not scatter because clouds keep the sun from it: taken from what each ray of the clouds adds
// to the picture, whose air is lit as if there were none. What is left of the air's light is between shafts.
//
// Only light that would be scattered once is in clouds' shadow; what has been scattered before comes from all sides.
#include "clouds/view_ray.glsl"
#include "clouds/sun_depth.glsl"
#include "clouds/shadowed_air.glsl"

layout(local_size_x = 8, local_size_y = 4) in;
layout(binding = 0, rgba32f) uniform image2D u_rays;
layout(binding = 1, r32f) uniform image2D u_distance;
layout(location = 5) uniform int u_shaft_steps;
layout(location = 8) uniform float u_shaft_share;        // how much of the shadow counts
layout(location = 9) uniform float u_first_shaft_step;   // about as long, in metres

const float CLEAR = 1e-3;

const float LEAST_RISE = 0.01;   // cosine to the zenith of a sun's ray where it crosses the maps' height

// A map that knows a step: layer in the texture, how much it counts, where the step's middle lies and how that moves
// per metre along the ray. No array: each lane would look for its own element.
struct KnownBy {
    float first, share;
    vec2 at, drift;
};
KnownBy g_fine, g_coarse;   // the finer one first
float g_dip;

void cloud_sun_at(AirStep place) {
    vec3 sun = frame.sun_direction;
    float r = planet.radius_m + place.altitude, unused;
    float path_m = distance_to_rise(r, place.mu_s, cloud_view.shadow_height_m - place.altitude);
    vec3 D = foot_offset_of(place.point + sun * path_m, unused);
    // The crossing stays at its height X: X . (ray + path_m' sun) = 0.
    vec3 drift = place.ray - sun * ((r * place.mu + path_m * place.nu) / max(r * place.mu_s + path_m, LEAST_RISE * r));
    int level = cloud_first_map(D, place.footprint_m), levels = cloud_view.shadow_map_count;
    float left = 1.0;
    g_fine = g_coarse = KnownBy(0.0, 0.0, vec2(0.0), vec2(0.0));
    do {
        vec2 at = cloud_map_place(D, level);
        float known = left * cloud_map_share(at, level);
        KnownBy by = KnownBy(float(level * (CLOUD_MOST_INTERVALS + 1)) + 0.5, known, at, cloud_map_turn(drift, level));
        if (g_fine.share > 0.0) g_coarse = by;
        else g_fine = by;
        left -= known;
    } while (++level < levels && g_coarse.share <= 0.0 && left > 0.0);
    // Where neither knows all, the rest is as they are on the mean.
    float total = g_fine.share + g_coarse.share;
    g_fine.share /= max(total, 1e-6);
    g_coarse.share /= max(total, 1e-6);
    g_dip = cloud_sun_dip(place.altitude, place.mu_s);
}

float cloud_sun_left(AirStep place, float further) {
    float r = planet.radius_m + place.altitude;
    float altitude = place.altitude + further * (place.mu + 0.5 * further * (1.0 - place.mu * place.mu) / r);
    float node = cloud_node(altitude - g_dip), sum = 1.0 - g_fine.share - g_coarse.share;
    int maps = g_coarse.share > 0.0 ? 2 : 1, k = 0;
    KnownBy by = g_fine;
    do {
        vec2 at = 0.5 + 0.5 * clamp(by.at + by.drift * further, -1.0, 1.0);
        float row = (by.first + node) / float(CLOUD_MOST_MAPS * (CLOUD_MOST_INTERVALS + 1));
        sum += by.share * textureLod(u_cloud_sun, vec3(at, row), 0.0).r;
        by = g_coarse;
    } while (++k < maps);
    return sum;
}

void main() {
    ivec2 at = cloud_block_of(ivec2(gl_GlobalInvocationID.xy));
    if (any(greaterThanEqual(at, imageSize(u_rays)))) return;
    ViewRay v = cloud_view_ray(at);
    vec4 clouds = imageLoad(u_rays, at);
    ShadowedAir air = shadowed_air(v.ray, v.mu, v.end, imageLoad(u_distance, at).r, clouds.a, u_shaft_steps,
        u_first_shaft_step, v.jitter);
    if (air.shadowed) {
        imageStore(u_rays, at, vec4(clouds.rgb - air.light * (u_shaft_share * frame.hdr_per_radiance), clouds.a));
        // Where there is nothing else to follow from frame to frame, the shafts are.
        if (1.0 - clouds.a < CLEAR) imageStore(u_distance, at, vec4(air.distance_m));
    }
}
