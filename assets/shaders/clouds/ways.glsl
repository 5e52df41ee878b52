// Where a ray from the camera goes through layers of cloud, and the ends of the segments between which weather is taken
// as even.
#include "clouds/shells.glsl"
#include "clouds/density.glsl"

const float NOT_ALL = 1e9;

#ifdef CLOUD_NO_ICE
const bool NO_ICE = true;
#else
const bool NO_ICE = false;
#endif

float pixel_rad;   // angle that a ray stands for
float ray_walked = 0.0;   // metres that it has come before its start, through nothing; distances count from there

// Layers are in the order of their heights: down through them from the highest, then up from the lowest. Returns how
// many ways there are. Without those of ice where the program has none.
int cloud_ways(float mu, float end, out vec2 spans[2 * CLOUD_VIEW_LAYERS], out int owners[2 * CLOUD_VIEW_LAYERS]) {
    int layers = cloud_view.layer_count, count = 0;
    for (int turn = 0; turn < 2 * layers; ++turn) {
        bool down = turn < layers;
        int layer = down ? layers - 1 - turn : turn - layers;
        vec4 ways = shell_ways(mu, cloud_view.layers[layer].base_m, cloud_view.layers[layer].top_m, end);
        vec2 way = down ? ways.xy : ways.zw;
        if (way.y - way.x >= 1e-3 && !(NO_ICE && cloud_view.layers[layer].kind == CLOUD_ICE)) {
            spans[count] = way;
            owners[count] = layer;
            ++count;
        }
    }
    return count;
}

// short steps through a layer's thickness, growth of a step with distance, 0, steps to the sun
layout(location = 0) uniform vec4 u_march;

const float WAY_STEPS = 96.0;   // that many short steps and no more, and segments are as long as they may be

// 0 where steps are so long that none can be spared, 1 where they are short: a layer's thickness in 24, in 56.
float way_fineness() {
    return clamp(u_march.x / 32.0 - 0.75, 0.0, 1.0);
}

// Weather changes over tens of kilometres: in a segment it is taken as even. Where steps are short, segments are.
int way_segments(CloudViewLayer shell, bool thin, float from, float to) {
    float finer = clamp(u_march.x / WAY_STEPS, 1.0, 16.0);
    float per_octave = mix(1.3, 2.0, way_fineness());   // of the way's length
    return int(finer * float(thin ? 1 : clamp(int(log2((to - from) * shell.per_thickness) * per_octave), 1, 8)));
}

float way_end(CloudViewLayer shell, float from, float to, int segment, int segments) {
    // more: even segments, in digits that f32 has
    float thickness = shell.top_m - shell.base_m + min(ray_walked, 10.0 * (to - from));
    float growth = log((to + thickness) / (from + thickness)) / float(segments);
    return segment == segments - 1 ? to : (from + thickness) * exp(growth * float(segment + 1)) - thickness;
}

// A pixel that sees the clouds at a low angle stands for a long stretch of them: the weather is the mean over the
// geometric mean of its width and its length, or rows of pixels near the limb would fall on clouds and on gaps by
// chance.
// cosine to the zenith: on a planet of any size level rays turn no longer stretches than that
const float LEAST_ANGLE = 0.02;

CloudWeather weather_along(vec3 ray, float t) {
    vec3 up = up_at(ray * t);
    float stretch = inversesqrt(max(abs(dot(ray, up)), LEAST_ANGLE));
    return cloud_weather(up, (t + ray_walked) * pixel_rad * stretch);
}
