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

layout(location = 1) uniform vec2 u_steepest;   // 1/m: of noise in the volumes of shapes and of cells; times finer
layout(location = 2) uniform int u_layers;      // of the block's, those with droplets
// By texel of the maps of weather, of those up to two texels around: 1/m of cover; of towers and of depth.
layout(binding = WEATHER_STEEP_UNIT) uniform sampler2D u_weather_steep;

const float PATH_REACH_M = 250.0;       // that a bound holds for inside clouds
const float PATH_CLEAR_M = 2000.0;      // and at most in the clear
const float PATH_CLEAR_EXCESS = -0.125; // of noise: no rim of a layer as it comes reaches from below it
const float PATH_FLAT_EXCESS = -0.2;    // and below this there are no rims (density.glsl, cloud_relief)
const float PATH_WEATHER_STEP = 1.0 / 255.0;   // of weather that is interpolated
const float PATH_TEXEL_STEP = 1.0 / 256.0;     // of a texel, in volumes
// Of cloud_streets, in a street: a wave (cloud_wave) is as steep as eight of its height in a period. A row, 16 x x with
// x = across (1 - across), is as steep as 3.08 in its width, which waves that bend it make 1.96 times less; along it as
// 0.42. Of where streets are: two waves.
const float PATH_STREET_STEEP = 6.5, PATH_PATCH_STEEP = 0.19;
const float PATH_ENDLESS = 1e9;
const float PATH_BEYOND_M = 0.05;       // that a path goes beyond a boundary, so as not to meet it again

struct PathMedium {
    float extinction, bound, reach;   // 1/m, 1/m, m
    float scattered, asymmetry;       // share of extinction; g, mean of the layers by what they scatter
};

// Cover and scarcity against the threshold, in one: increases with cover (density.glsl, cloud_noise). streets: how high
// they are at most.
float path_cover(float cover, float streets) {
    float scarce = 1.0 - clamp(cover / CLOUD_SCARCE, 0.0, 1.0);
    return cover - (CLOUD_MOST_NOISE + CLOUD_STREET_MOST * streets) * scarce * scarce;
}

// Largest share of the cover that heights within `away` (of the layer's thickness) of a place have, without an anvil.
float path_height_cover(CloudViewLayer shell, float share, float away, float tallness) {
    float top = (1.0 - (share - away) / tallness) * shell.steep;
    return smoothstep(0.0, shell.base, share + away) * clamp(top, 0.0, 1.0);
}

// Excess below which no rim reaches a cloud: what cloud_gap says of it.
float path_clear_excess(int layer, CloudNoise n) {
    n.cover = 1.0;
    n.excess = PATH_CLEAR_EXCESS;
    bool near = cloud_gap(layer, n, 0.0) > 0.0;
    n.excess = PATH_FLAT_EXCESS;
    return near ? PATH_CLEAR_EXCESS : cloud_gap(layer, n, 0.0) > 0.0 ? PATH_FLAT_EXCESS : -PATH_ENDLESS;
}

// As cloud_weather looks maps up.
vec2 path_weather_steep(vec3 up) {
    float inner = cloud_view.map_texels, border = cloud_view.map_border;
    vec2 at = ((0.5 + 0.5 * oct_encode(cloud_turned(up))) * inner + border) / (inner + 2.0 * border);
    return textureLod(u_weather_steep, at, 0.0).rg;
}

// Distance in which excess cannot reach path_clear_excess, and the bound of the density relative to the layer's within
// PATH_REACH_M. steep: of path_weather_steep.
//
// Each *_by is how much a term of cloud_noise may change at most: x in a metre, y at once, by the steps in which a GPU
// interpolates. Products of terms that are no larger than 1 change by no more than the sum of theirs.
vec2 path_bounds(int layer, CloudViewLayer shell, CloudWeather weather, CloudNoise n, float share, vec2 steep) {
#ifdef PATH_PLAIN
    return vec2(0.0, 1.0);   // none but the layer's densest
#else
    CloudWeather w = cloud_weather_of(shell, weather);
    float shape_m = 1.0 / (cloud_view.broad.per_m * float(textureSize(u_cloud_shape, 0).x)),
        cells_m = 1.0 / (cloud_view.wide.per_m * float(textureSize(u_cloud_cells, 0).x));
    vec2 shape_by = u_steepest.x * vec2(shell.finer, PATH_TEXEL_STEP * shape_m),
        cells_by = u_steepest.y * vec2(shell.finer, PATH_TEXEL_STEP * cells_m);
    vec2 towers_by = shell.follows * vec2(steep.y, PATH_WEATHER_STEP), solid_by = 2.0 * towers_by;
    float most = clamp(w.cover * shell.cover_scale, 0.0, 1.0) * (1.0 - CLOUD_SEAMS * (1.0 - cloud_solid(w)));
    vec2 most_by = shell.cover_scale * vec2(steep.x, PATH_WEATHER_STEP) + CLOUD_SEAMS * solid_by;
    // Open cells (cloud_open: 5 by towers, 4 by depth), and where the trades' belt ends: from 1 to 0 over a fifth of
    // the planet's radius. Streets: by cover, and in patches whose waves are 60 streets and more long.
    float street_m = CLOUD_STREET_WIDE * cloud_view.thickness_m / shell.finer;
    vec2 blown_by = 9.0 * towers_by + vec2(5.0 * cloud_view.bend.per_m, 0.0),
        streets_by = CLOUD_STREETS * (blown_by + 5.0 * most_by + vec2(PATH_PATCH_STEEP / street_m, 0.0));
    float most_streets = min(n.streets + PATH_CLEAR_M * streets_by.x + streets_by.y, CLOUD_STREETS);
    vec2 row_by = vec2(PATH_STREET_STEEP / street_m, 0.0);
    // Where cells are open they are turned out: a factor from 1 to -1 on what is 0.5 at most; streets take their place.
    vec2 wide_by = shell.rough * CLOUD_CLUSTERS * (cells_by + blown_by)
        + 0.5 * shell.rough * CLOUD_CLUSTERS * CLOUD_STREET_CELLS / CLOUD_STREETS * streets_by;
    // Streets count twice: in the noise and in what scarce cover takes.
    vec2 noise_by = shell.rough * CLOUD_CELLS * shape_by + wide_by + 2.0 * most_streets * row_by
        + 2.0 * CLOUD_STREET_MOST * streets_by;
    float noise = n.excess + 0.5 - path_cover(n.cover, n.streets), clear = path_clear_excess(layer, n);
    // Whatever the height: an anvil may have more than the whole cover. Where cover is scarce, path_cover is 12.5 times
    // as steep as cover.
    float whole = max(shell.anvil, 1.0),
        scarce = 1.0 - clamp((most - PATH_CLEAR_M * most_by.x - most_by.y) / CLOUD_SCARCE, 0.0, 1.0);
    vec2 flat_by = noise_by + (1.0 + 11.5 * scarce) * whole * most_by;
    float flat_excess = noise - 0.5 + path_cover(whole * most, n.streets) + flat_by.y,
        flat_m = (clear - flat_excess) / flat_by.x;
    // By heights around, without an anvil: tops rise with towers.
    float near_m = PATH_REACH_M, away = near_m * shell.per_thickness;
    vec2 tops_by = shell.steep * (1.0 - shell.least_tall) / shell.least_tall * towers_by,
        near_by = noise_by + 12.5 * (most_by + tops_by);
    float near_cover = most * path_height_cover(shell, share, away, cloud_tallness(shell, w)),
        near_excess = noise - 0.5 + path_cover(near_cover, n.streets) + near_by.y,
        near_clear_m = shell.anvil > 0.0 ? 0.0 : (clear - near_excess) / near_by.x;
    float thickness = n.thickness + dot(wide_by + most_by, vec2(near_m, 1.0));
    // Where optical thickness is spread, by as much as there may be.
    float interior = (cloud_view.thickness_spread > 0.0 ? 1.0
            : min(n.interior + dot(solid_by, vec2(near_m, 1.0)), 1.0))
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
        vec2 bounds = path_bounds(layer, shell, w, n, within, steep);
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
