// How much sunlight the clouds leave at a point of the air or of a cloud, from the maps of the shadow.
//
//   vec2 cloud_sunlight(vec3 point, float altitude, float mu_s, float wide_m)
//
// point: camera-relative, planet axes; mu_s: cosine of the sun to the zenith there; wide_m: what the answer stands for.
// x: the beam's share that is left; y: optical depth of all clouds towards the sun. Of a sun below the point's horizon
// it is that of the ray from its lowest point on: what lies between the two is not in the maps.
#include "generated/bindings.glsl"
#include "clouds/shadow_maps.glsl"

layout(binding = CLOUD_SUN_UNIT) uniform sampler3D u_cloud_sun;

struct CloudSunPlace {
    vec3 D;      // foot offset of the place where the sun's ray crosses the maps' height
    int level;   // the first map to ask
};

CloudSunPlace cloud_sun_ray(vec3 point, float altitude, float mu_s, float wide_m) {
    float unused;
    vec3 D = foot_offset_of(cloud_sun_place(point, altitude, mu_s), unused);
    return CloudSunPlace(D, cloud_first_map(D, wide_m));
}

// How far the lowest point of the sun's ray lies below a place.
float cloud_sun_dip(float altitude, float mu_s) {
    return mu_s < 0.0 ? (planet.radius_m + altitude) * mu_s * mu_s / (1.0 + sqrt(1.0 - min(mu_s * mu_s, 1.0))) : 0.0;
}

// From a height on that ray on. Of a sun below the point's horizon: from its lowest point on.
vec2 cloud_sunlight_on(CloudSunPlace ray, float altitude, float mu_s) {
    float node = cloud_node(altitude - cloud_sun_dip(altitude, mu_s)) + 0.5, rows = float(CLOUD_MOST_INTERVALS + 1);
    vec2 sum = vec2(0.0);
    float left = 1.0;
    int levels = cloud_view.shadow_map_count, level = ray.level;
    do {
        vec2 at = cloud_map_place(ray.D, level);
        float known = left * cloud_map_share(at, level),
            row = (float(level) * rows + node) / (float(CLOUD_MOST_MAPS) * rows);
        sum += known * textureLod(u_cloud_sun, vec3(0.5 + 0.5 * clamp(at, -1.0, 1.0), row), 0.0).rg;
        left -= known;
    } while (++level < levels && left > 0.0);
    return sum + vec2(left, 0.0);
}

vec2 cloud_sunlight(vec3 point, float altitude, float mu_s, float wide_m) {
    return cloud_sunlight_on(cloud_sun_ray(point, altitude, mu_s, wide_m), altitude, mu_s);
}

// Optical depths alone, from three heights of one ray on: heights in the maps (cloud_node).
vec3 cloud_depths_on(CloudSunPlace ray, vec3 nodes) {
    float rows = float(CLOUD_MOST_INTERVALS + 1);
    vec3 sum = vec3(0.0);
    float left = 1.0;
    int levels = cloud_view.shadow_map_count, level = ray.level;
    do {
        vec2 at = cloud_map_place(ray.D, level), place = 0.5 + 0.5 * clamp(at, -1.0, 1.0);
        float known = left * cloud_map_share(at, level);
        vec3 row = (float(level) * rows + nodes + 0.5) / (float(CLOUD_MOST_MAPS) * rows);
        sum += known * vec3(textureLod(u_cloud_sun, vec3(place, row.x), 0.0).g,
            textureLod(u_cloud_sun, vec3(place, row.y), 0.0).g, textureLod(u_cloud_sun, vec3(place, row.z), 0.0).g);
        left -= known;
    } while (++level < levels && left > 0.0);
    return sum;
}
