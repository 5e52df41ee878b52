// What paths of light meet: extinction of all droplets at a place, by the very density that pictures are drawn with and
// no footprint, and a bound of it around the place.
//
//   PathMedium path_medium(vec3 point, float altitude, vec3 up)
//   float path_to_boundary(float altitude, float mu)     metres to the next height where a layer or the ground begins
//
// A bound holds within `reach` metres: a flight looks no farther before it asks again. In the clear the bound is 0:
// noise is as steep as its steepest texels, weather as its texels around, so what lies far below the threshold stays
// below it for a while.
#include "common/camera.glsl"
#include "clouds/density.glsl"

layout(location = 1) uniform vec2 u_steepest;   // 1/m: of noise in the volumes broad and wide
layout(location = 2) uniform int u_layers;      // of the block's, those with droplets
// By texel of the maps of weather, of those up to two texels around: 1/m of cover; of towers and of depth.
layout(binding = 6) uniform sampler2D u_weather_steep;

const float PATH_REACH_M = 250.0;       // that a bound holds for inside clouds
const float PATH_CLEAR_M = 2000.0;      // and at most in the clear
const float PATH_CLEAR_EXCESS = -0.125; // of noise: no rim reaches from below it (cloud_gap: excess + 0.33 relief < 0)
const float PATH_ENDLESS = 1e9;
const float PATH_BEYOND_M = 0.05;       // that a path goes beyond a boundary, so as not to meet it again

struct PathMedium {
    float extinction, bound, reach;   // 1/m, 1/m, m
    float scattered, asymmetry;       // share of extinction; g, mean of the layers by what they scatter
};

// Cover and scarcity against the threshold, in one: increases with cover (density.glsl, cloud_noise).
float path_cover(float cover) {
    float scarce = 1.0 - clamp(cover / CLOUD_SCARCE, 0.0, 1.0);
    return cover - CLOUD_MOST_NOISE * scarce * scarce;
}

// Largest share of the cover that heights within `away` (of the layer's thickness) of a place have.
float path_height_cover(float share, float away, float tallness) {
    float top = (1.0 - (share - away) / tallness) * (1.0 / 0.85);
    return smoothstep(0.0, 0.10, share + away) * clamp(top, 0.0, 1.0);
}

// As cloud_weather looks maps up.
vec2 path_weather_steep(vec3 up) {
    float inner = cloud_view.map_texels, border = cloud_view.map_border;
    vec2 at = ((0.5 + 0.5 * oct_encode(cloud_turned(up))) * inner + border) / (inner + 2.0 * border);
    return textureLod(u_weather_steep, at, 0.0).rg;
}

// Distance in which excess cannot reach PATH_CLEAR_EXCESS, and the bound of the density relative to the layer's within
// PATH_REACH_M. steep: of path_weather_steep.
vec2 path_bounds(CloudViewLayer shell, CloudWeather w, CloudNoise n, float share, vec2 steep) {
#ifdef PATH_PLAIN
    return vec2(0.0, 1.0);   // none but the layer's densest
#else
    float shallow = 1.0 - cloud_solid(w), tallness = cloud_tallness(w);
    float most = clamp(w.cover * shell.cover_scale, 0.0, 1.0) * (1.0 - CLOUD_SEAMS * shallow);
    float noise = n.excess + 0.5 - path_cover(n.cover);
    // Of solid 2 by towers or depth, of the clusters' weight 0.2 * 3 by towers, of their height 2.8. Where cover is
    // scarce, path_cover is ten times as steep as cover.
    float clusters_per_m = 0.6 * steep.y, most_per_m = shell.cover_scale * steep.x + 2.0 * CLOUD_SEAMS * steep.y,
        scarce = 1.0 - clamp((most - PATH_CLEAR_M * most_per_m) / CLOUD_SCARCE, 0.0, 1.0);
    // Warping stretches by 2.44 at most; rolls are a parabolic wave, eight of its height in a period, moved by `wide`.
    float wide_per_m = 2.44 * u_steepest.y, rolls = CLOUD_ROLLS * shallow;
    float noise_per_m = 0.94 * u_steepest.x + (0.55 + 14.0 * rolls) * wide_per_m
        + 8.0 * rolls * cloud_view.fine.per_m + clusters_per_m + 2.0 * CLOUD_ROLLS * steep.y;
    float flat_excess = noise - 0.5 + path_cover(most),
        flat_m = (PATH_CLEAR_EXCESS - flat_excess) / (noise_per_m + (1.0 + 9.0 * scarce) * most_per_m);
    float near_m = PATH_REACH_M, away = near_m * shell.per_thickness;
    float near_excess = noise - 0.5 + path_cover(most * path_height_cover(share, away, tallness)),
        near_clear_m = (PATH_CLEAR_EXCESS - near_excess) / (noise_per_m + 10.0 * (most_per_m + 2.8 * steep.y));
    float thickness = n.thickness + near_m * (0.55 * wide_per_m + most_per_m + clusters_per_m);
    float interior = min(n.interior + 2.0 * near_m * steep.y, 1.0)
        * exp2(-2.0 * (1.0 - smoothstep(-0.25, 0.4, thickness)));
    return vec2(min(max(flat_m, min(near_clear_m, near_m)), PATH_CLEAR_M), interior);
#endif
}

PathMedium path_medium(vec3 point, float altitude, vec3 up) {
    PathMedium found = PathMedium(0.0, 0.0, PATH_ENDLESS, 0.0, 0.0);
    CloudWeather w = cloud_weather(up, 0.0);
    vec2 steep = path_weather_steep(up);
    int layer = 0;
    do {
        CloudViewLayer shell = cloud_view.layers[layer];
        float share = (altitude - shell.base_m) * shell.per_thickness;
        bool inside = share >= 0.0 && share <= 1.0 && layer < u_layers;
        float within = clamp(share, 0.0, 1.0), extinction = inside ? shell.extinction_per_m : 0.0;
        CloudNoise n = cloud_noise(layer, point, within, w, 0.0);
        float density = extinction * cloud_rimmed(layer, n, within, 0.0, 2);
        vec2 bounds = path_bounds(shell, w, n, within, steep);
        bool even = shell.kind == CLOUD_UNIFORM;
        float bound = even ? extinction : extinction * bounds.y, reach = even ? PATH_ENDLESS : PATH_REACH_M;
        // Clear for longer than a flight would be.
        bool clear = !even && bounds.x * bound > 0.5;
        found.bound += clear ? 0.0 : bound;
        found.reach = inside ? min(found.reach, clear ? bounds.x : reach) : found.reach;
        found.extinction += density;
        found.scattered += shell.albedo * density;
        found.asymmetry += shell.albedo * density * shell.asymmetry;
    } while (++layer < u_layers);
    found.asymmetry /= max(found.scattered, 1e-30);
    found.scattered /= max(found.extinction, 1e-30);
    return found;
}

// Metres along a ray of cosine mu to the zenith to the sphere of a height; PATH_ENDLESS if it doesn't meet it.
float path_to_height(float altitude, float mu, float height) {
    float b = (planet.radius_m + altitude) * mu, c = (altitude - height) * (2.0 * planet.radius_m + altitude + height);
    float inside = b * b - c, root = sqrt(max(inside, 0.0));
    float down = b < 0.0 && inside > 0.0 ? c / (root - b) : PATH_ENDLESS,
        out_ = b >= 0.0 ? -c / max(root + b, 1e-10) : root - b;
    return altitude > height ? down : out_;
}

float path_to_boundary(float altitude, float mu) {
    float nearest = path_to_height(altitude, mu, 0.0);
    int layer = 0;
    do {
        nearest = min(nearest, min(path_to_height(altitude, mu, cloud_view.layers[layer].base_m),
            path_to_height(altitude, mu, cloud_view.layers[layer].top_m)));
    } while (++layer < u_layers);
    return nearest;
}
