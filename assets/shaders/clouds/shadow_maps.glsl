// Which maps of the shadow show a place: the finest that has it, the next one coming in over its last fifth.
#include "clouds/sun_ray.glsl"

// A way in metres along the foot offsets, on a map that is 2 wide and 2 long.
vec2 cloud_map_turn(vec3 away, int level) {
    return vec2(dot(away, cloud_view.shadow_maps[level].u), dot(away, cloud_view.shadow_maps[level].v))
        * cloud_view.shadow_maps[level].per_half_width;
}

// Place on a map, -1..1. D: foot offset of the place.
vec2 cloud_map_place(vec3 D, int level) {
    return cloud_map_turn(D + cloud_view.shadow_maps[level].to_anchor_m, level);
}

float cloud_map_texel(int level) {
    return 2.0 / (cloud_view.shadow_maps[level].per_half_width * cloud_view.shadow_texels);
}

// The first map to ask for a place, no finer than a width in metres calls for, nor than any that is drawn: each look
// takes time. Each is four times wider than the one before, and about in the same middle. holds: the finest that may
// have the place.
int cloud_first_map(float holds, float wide_m) {
    float shows = 0.5 * log2(max(wide_m / cloud_map_texel(0), 1e-3));
    return clamp(int(max(max(holds, shows), cloud_view.finest_map)), 0, max(cloud_view.shadow_map_count - 1, 0));
}

float cloud_map_reach(vec3 D) {
    vec2 at = abs(cloud_map_place(D, 0));
    return max(at.x, at.y);
}

// For a place and those around it.
int cloud_first_map(vec3 D, float wide_m) {
    return cloud_first_map(0.5 * (log2(max(cloud_map_reach(D), 1e-3)) - 0.2), wide_m);
}

// For the place alone. Middles lie within 0.625 of a map's half width of those of finer ones
// (systems/clouds/shadow.py): 2^0.7 - 1. A first map that is not drawn lies anywhere.
int cloud_first_map_of(vec3 D, float wide_m) {
    float reach = cloud_view.finest_map > 0.0 ? 0.0 : cloud_map_reach(D);
    return cloud_first_map(reach < 1.0 ? 0.0 : 1.0 + 0.5 * max(log2(reach) - 0.7, 0.0), wide_m);
}

// How much of a map counts where the ones before have left something: nothing until it is drawn.
float cloud_map_share(vec2 at, int level) {
    return clamp(5.0 - 5.0 * max(abs(at.x), abs(at.y)), 0.0, 1.0) * cloud_view.shadow_maps[level].drawn;
}
