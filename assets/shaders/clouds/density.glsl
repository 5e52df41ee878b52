// How dense the clouds are at a place: extinction relative to that of the layer's densest cloud, 0..1.
//
//   CloudWeather cloud_weather(vec3 up, float footprint_m)        of a direction from the planet's centre
//   float cloud_density(int layer, vec3 place, float share, CloudWeather w, float footprint_m, int rims)
//   float cloud_column(int layer, CloudWeather w, float density)        optical depth, from base to top
//
// place: metres from the anchor in planet axes; share: height in the layer, 0 base .. 1 top; footprint_m: what the sample stands
// for, a pixel's width or a step's length. rims: octaves of billows on the rim, 0..2.
//
// Noise is spread evenly over 0..1, so "noise above 1 - cover" is cloud on a share `cover` of the space. What a footprint is too
// wide to show is not dropped but averaged: the share of the values it hides that lie above the threshold, so the same cloud
// that is a thing with edges from near is a grey of the right mean from far, and coverage is the same at all distances.
#include "common/octahedral.glsl"
#include "generated/cloud_view.glsl"

layout(binding = 0) uniform sampler3D u_cloud_shape;
layout(binding = 1) uniform sampler3D u_cloud_rims;
layout(binding = 2) uniform sampler2D u_weather_first;
layout(binding = 3) uniform sampler2D u_weather_second;

// Where a volume of noise lies around the point that places are measured from.
#ifndef CLOUD_ORIGIN
#define CLOUD_ORIGIN(volume) cloud_view.volume.xyz
#endif

const float CLOUD_RIM = 0.13;         // of the rims' noise against the shape's
const float CLOUD_RIM_NEAR = 0.035;
const float CLOUD_EDGE = 0.11;        // of noise above the threshold until the cloud is densest
const float CLOUD_SCARCE = 0.12;      // cover below which the threshold rises out of reach
const float CLOUD_FILLED = 0.4;       // of the height of clouds, by what is in them on the mean: thin bases, tops and places
const float CLOUD_BEYOND = 0.54;      // sqrt(0.5) - 0.5 of two volumes whose weights are a unit vector, and twice the rims' weights

// Between two levels of a volume chance decides, ray by ray: one fetch instead of two. 0..1, set by whoever marches.
float cloud_dither = 0.5;

struct CloudWeather {
    float cover, towers, high, deep;
};

CloudWeather cloud_weather(vec3 up, float footprint_m) {
    vec3 d = cloud_view.turn[0].xyz * up.x + cloud_view.turn[1].xyz * up.y + cloud_view.turn[2].xyz * up.z;
    float inner = cloud_view.weather.y, border = cloud_view.weather.z;
    vec2 at = ((0.5 + 0.5 * oct_encode(d)) * inner + border) / (inner + 2.0 * border);
    float level = clamp(log2(max(footprint_m / cloud_view.weather.w, 1.0)), 0.0, 4.0);
    vec4 w = mix(textureLod(u_weather_first, at, level + cloud_dither - 0.5), textureLod(u_weather_second, at, level + cloud_dither - 0.5), cloud_view.weather.x);
    return CloudWeather(w.x, w.y, w.z, w.w);
}

CloudWeather cloud_weather_between(CloudWeather a, CloudWeather b, float share) {
    return CloudWeather(mix(a.cover, b.cover, share), mix(a.towers, b.towers, share), mix(a.high, b.high, share),
        mix(a.deep, b.deep, share));
}

// Mean over values within `half_width` around x of a ramp from 0 at 0 to 1 at `edge`: the difference of its integral.
float cloud_ramp_sum(float x, float edge) {
    float inside = clamp(x, 0.0, edge);
    return 0.5 * inside * inside / edge + max(x - edge, 0.0);
}

float cloud_ramp(float x, float half_width, float edge) {
    return (cloud_ramp_sum(x + half_width, edge) - cloud_ramp_sum(x - half_width, edge)) / (2.0 * half_width);
}

float cloud_level(float per_metre_level, float footprint_m) {
    return max(per_metre_level + log2(max(footprint_m, 1e-3)), 0.0);
}

// Share of the noise's variance that a level doesn't show.
float cloud_hidden(float level, float half_way, float slope) {
    return clamp(0.5 + (level - half_way) * slope, 0.0, 1.0);
}

vec3 cloud_turned(vec3 place) {
    return cloud_view.turn[0].xyz * place.x + cloud_view.turn[1].xyz * place.y + cloud_view.turn[2].xyz * place.z;
}

vec3 cloud_tilted(vec3 place) {
    return cloud_view.tilt[0].xyz * place.x + cloud_view.tilt[1].xyz * place.y + cloud_view.tilt[2].xyz * place.z;
}

// How much of the layer's thickness clouds of a weather fill.
float cloud_tallness(CloudWeather w) {
    return mix(0.30, 1.0, w.towers);
}

// How much of the map's cover a height in the layer has: a flat base, tops that reach as high as the weather lets them.
float cloud_height_cover(float share, CloudWeather w) {
    float x = share / cloud_tallness(w);
    return smoothstep(0.0, 0.10, share) * clamp(1.0 - x * x, 0.0, 1.0);
}

// How dense the inside of clouds is that a weather makes: sheets are thin; fronts and towers are not.
float cloud_body(CloudWeather w) {
    return mix(0.06, 1.0, clamp(max(w.deep * w.deep, 1.3 * w.towers - 0.65), 0.0, 1.0));
}

// Vertical optical depth of a whole cloud of a weather. density: at some place in it; ice is as it is there all the way.
float cloud_column(int layer, CloudWeather w, float density) {
    vec4 shell = cloud_view.shell[layer], drops = cloud_view.droplets[layer];
    float even = mix(1.0, 2.0 / 3.0, cloud_view.shape[layer].x);
    float billows = CLOUD_FILLED * cloud_tallness(w) * cloud_body(w);
    return (shell.y - shell.x) * shell.w * (drops.z == 2.0 ? even : drops.z == 1.0 ? density : billows);
}

// Thinner because it is in clumps that hide one another: as a binary mixture of cloud and clear air (Pomraning 1991).
float cloud_clumped(float share, float hidden, float extinction) {
    return share / (1.0 + hidden * (1.0 - share) * extinction * cloud_view.stretch.w);
}

// 1 where a footprint leaves enough of a volume's period to tell its cells apart, 0 where a handful of texels would be left: those
// look the same period after period.
float cloud_told(float footprint_m, float per_period) {
    return 1.0 - smoothstep(0.05, 0.2, footprint_m * per_period);
}

// All kinds of layer in one line of code: software GPUs go through both sides of a branch, and once through loops of no turns.
float cloud_density(int layer, vec3 place, float share, CloudWeather w, float footprint_m, int rims) {
    vec4 drops = cloud_view.droplets[layer];
    bool ice = drops.z == 1.0;
    vec3 turned = cloud_turned(place), tilted = cloud_tilted(place), drawn = turned * cloud_view.stretch.xyz;
    // Thin ice: drawn out streaks on the map, fibres of the volume in them. Else clouds of two sizes.
    vec3 first = ice ? CLOUD_ORIGIN(fibre) + drawn * cloud_view.fibre.w : CLOUD_ORIGIN(broad) + turned * cloud_view.broad.w;
    vec3 second = ice ? CLOUD_ORIGIN(veil) + drawn.yzx * cloud_view.veil.w : CLOUD_ORIGIN(wide) + tilted * cloud_view.wide.w;
    float first_level = cloud_level(cloud_view.fade.x - (ice ? 1.5 : 0.0), footprint_m);
    float second_level = ice ? first_level : cloud_level(cloud_view.fade.y, footprint_m);
    float broad = textureLod(u_cloud_shape, first, first_level + cloud_dither - 0.5).r - 0.5;
    float wide = textureLod(u_cloud_shape, second, second_level + cloud_dither - 0.5).r - 0.5;
    // The streaks' period is shortest across them.
    float first_told = cloud_told(footprint_m, ice ? 0.3 * cloud_view.fibre.w : cloud_view.broad.w);
    float second_told = cloud_told(footprint_m, ice ? 0.3 * cloud_view.veil.w : cloud_view.wide.w);
    float first_shown = first_told * first_told * (1.0 - cloud_hidden(first_level, cloud_view.hiding.x, cloud_view.hiding.y));
    float second_shown = second_told * second_told * (1.0 - cloud_hidden(second_level, cloud_view.hiding.x, cloud_view.hiding.y));
    broad *= first_told;
    wide *= second_told;

    float streaks = 0.4 * broad + 0.4 * wide + w.high * drops.w - 0.62;
    float soft = max(0.3 * sqrt(1.0 - second_shown), 0.02);
    float thin = cloud_ramp(streaks, soft, 0.5);

    // Sheets are of small cells, deep weather is in clusters. Squares of the weights add up to one: the variance stays that of
    // one volume.
    float clusters = mix(0.40, 0.80, smoothstep(0.25, 0.75, w.towers)), cells = sqrt(1.0 - clusters * clusters);
    float noise = cells * broad + clusters * wide;
    float hidden = 1.0 - cells * cells * first_shown - clusters * clusters * second_shown;
    float most = clamp(w.cover * drops.w, 0.0, 1.0), cover = most * cloud_height_cover(share, w);
    // Two volumes in one reach beyond 0.5, and rims on top of them: without this there would be cloud where there is no cover, cut
    // off along the line where cover begins.
    float scarce = 1.0 - clamp(cover / CLOUD_SCARCE, 0.0, 1.0);
    float x = noise - (0.5 - cover) - CLOUD_BEYOND * scarce * scarce, lost = 0.25 * hidden;
    int turns = x > -0.3 - 0.5 * sqrt(lost) && hidden < 0.99 && !ice ? rims : 0;
    for (int i = 0; i < turns; ++i) {
        vec3 origin = i == 0 ? CLOUD_ORIGIN(fine) : CLOUD_ORIGIN(finest);
        float per_metre = i == 0 ? cloud_view.fine.w : cloud_view.finest.w;
        float level = cloud_level(i == 0 ? cloud_view.fade.z : cloud_view.fade.w, footprint_m);
        float weight = i == 0 ? CLOUD_RIM : CLOUD_RIM_NEAR;
        float rim = textureLod(u_cloud_rims, origin + (i == 0 ? tilted : turned) * per_metre, level + cloud_dither - 0.5).r - 0.5;
        // Billows above, wisps below: at the base the noise is turned round.
        x += 2.0 * weight * rim * mix(-1.0, 1.0, smoothstep(0.0, 0.25, share));
        lost += weight * weight * cloud_hidden(level, cloud_view.hiding.z, cloud_view.hiding.w);
    }
    float dense = cloud_ramp(x, max(sqrt(lost), 0.015), CLOUD_EDGE) * step(1e-4, cover);
    // Sheets that close the sky are of thick and thin places all the same.
    float body = mix(0.3, 1.0, smoothstep(0.0, 0.7, x + 0.3 * (1.0 - cover)));
    float deep = body * cloud_body(w);
    float billows = deep * cloud_clumped(dense, hidden, deep * cloud_view.shell[layer].w);

    float even = drops.w > 0.0 ? 1.0 : 0.0;
    float density = drops.z == 2.0 ? even : ice ? thin : billows;
    return density * mix(1.0, 4.0 * share * (1.0 - share), cloud_view.shape[layer].x);
}
