// The weather at a place, and the frames in which clouds drift with the wind.
//
//   CloudWeather cloud_weather(vec3 up, float footprint_m)        of a direction from the planet's centre
#include "generated/bindings.glsl"
#include "common/octahedral.glsl"
#include "generated/cloud_view.glsl"

layout(binding = WEATHER_FIRST_UNIT) uniform sampler2D u_weather_first;
layout(binding = WEATHER_SECOND_UNIT) uniform sampler2D u_weather_second;
layout(binding = CLOUD_CELLS_UNIT) uniform sampler3D u_cloud_cells;

// Where noise lies around the point that places are measured from.
#ifndef CLOUD_ORIGIN
#define CLOUD_ORIGIN(volume) cloud_view.volume.origin
#endif

// Between two levels of a map or a volume chance decides, ray by ray: one fetch instead of two. 0..1, set by whoever
// marches.
float cloud_dither = 0.5;

// In the frames of the two volumes of noise (CloudViewBlock).
vec3 cloud_turned(vec3 place) {
    return cloud_view.turn * place;
}

vec3 cloud_tilted(vec3 place) {
    return cloud_view.tilt * place;
}

struct CloudWeather {
    float cover, towers, high, deep;
    float thickness;   // noise of how thick clouds are in such weather, 0..1
};

float cloud_level(float per_metre_level, float footprint_m) {
    return max(per_metre_level + log2(max(footprint_m, 1e-3)), 0.0);
}

CloudWeather cloud_weather(vec3 up, float footprint_m) {
    vec3 d = cloud_turned(up);
    float inner = cloud_view.map_texels, border = cloud_view.map_border;
    vec2 at = ((0.5 + 0.5 * oct_encode(d)) * inner + border) / (inner + 2.0 * border);
    float level = clamp(log2(max(footprint_m / cloud_view.map_texel_m, 1.0)), 0.0, 4.0);
    vec4 w = mix(textureLod(u_weather_first, at, level + cloud_dither - 0.5),
        textureLod(u_weather_second, at, level + cloud_dither - 0.5), cloud_view.second_map_share);
    float thickness = textureLod(u_cloud_cells, d * cloud_view.thickness_periods,
        cloud_level(cloud_view.thickness_level, footprint_m) + cloud_dither - 0.5).r;
    return CloudWeather(w.x, w.y, w.z, w.w, thickness);
}

CloudWeather cloud_weather_between(CloudWeather a, CloudWeather b, float share) {
    return CloudWeather(mix(a.cover, b.cover, share), mix(a.towers, b.towers, share), mix(a.high, b.high, share),
        mix(a.deep, b.deep, share), mix(a.thickness, b.thickness, share));
}

// 1 where a footprint leaves enough of a period to tell its cells apart, 0 where a handful of texels would be left:
// those look the same period after period.
float cells_resolved(float footprint_m, float per_period) {
    return 1.0 - smoothstep(0.05, 0.2, footprint_m * per_period);
}
