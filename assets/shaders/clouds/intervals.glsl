// Intervals of a ray from the camera inside layers of cloud, and the segments of each between whose ends the weather is
// interpolated.
#include "clouds/shells.glsl"
#include "clouds/density.glsl"

const float UNBOUNDED = 1e9;   // m: a ray that ends on nothing, the distance of no cloud

#ifdef CLOUD_NO_CIRRUS
const bool NO_CIRRUS = true;
#else
const bool NO_CIRRUS = false;
#endif

float pixel_rad;   // angle that a ray stands for
float ray_skipped_m = 0.0;   // empty space before the ray's start; distances count from the start

// Sizes of steps, of the quality (engine side: systems/clouds/view_march.py, MarchSteps).
layout(location = 0) uniform float u_layer_steps;   // short steps through a layer's thickness
layout(location = 6) uniform float u_step_growth;   // of a step's length with distance, m/m
layout(location = 7) uniform float u_sun_steps;     // towards the sun through a layer

const float COARSE_STEPS = 96.0;   // that many short steps and no more, and segments are as long as they may be
const float SEGMENTS_PER_OCTAVE_COARSE = 1.3, SEGMENTS_PER_OCTAVE = 2.0;   // of the interval's length in thicknesses
const float LEAST_MU = 0.02;   // of a ray to the zenith: level ones lengthen a footprint no further on any planet

// Layers are in the order of their heights: down through them from the highest, then up from the lowest. Returns how
// many intervals there are, from the nearest to the farthest. Without those of cirrus where the program has none.
int cloud_intervals(
    float mu, float end, out vec2 intervals[2 * CLOUD_VIEW_LAYERS], out int owners[2 * CLOUD_VIEW_LAYERS]
) {
    int layers = cloud_view.layer_count, count = 0;
    for (int turn = 0; turn < 2 * layers; ++turn) {
        bool down = turn < layers;
        int layer = down ? layers - 1 - turn : turn - layers;
        vec4 both = shell_intervals(mu, cloud_view.layers[layer].base_m, cloud_view.layers[layer].top_m, end);
        vec2 interval = down ? both.xy : both.zw;
        if (interval.y - interval.x >= 1e-3 && !(NO_CIRRUS && cloud_view.layers[layer].kind == CLOUD_CIRRUS)) {
            intervals[count] = interval;
            owners[count] = layer;
            ++count;
        }
    }
    return count;
}

// 0 where steps are so long that none can be spared, 1 where they are short: a layer's thickness in 24, in 56.
float step_fineness() {
    return clamp(u_layer_steps / 32.0 - 0.75, 0.0, 1.0);
}

// Weather changes over tens of kilometres: in a segment it is taken as even. Where steps are short, segments are. Not a
// whole number: the last segment is a part of one, and grows from nothing. Rays beside one another of which one had a
// segment more would show where that begins, as an arc across the sky.
float segment_count(CloudViewLayer shell, float from, float to) {
    float finer = clamp(u_layer_steps / COARSE_STEPS, 1.0, 16.0);
    float per_octave = mix(SEGMENTS_PER_OCTAVE_COARSE, SEGMENTS_PER_OCTAVE, step_fineness());
    return finer * clamp(log2((to - from) * shell.per_thickness) * per_octave - 1.0, 1.0, 8.0);
}

// A ray meets a sheet of ice in the middle of its way through the layer: at one place, or, where it runs along in it,
// at a few that move apart as the way gets longer.
const float CIRRUS_ALONG = 10.0, CIRRUS_ALL_ALONG = 40.0;   // thicknesses of the layer: from here on, and all apart
const int CIRRUS_PLACES = 4;

float cirrus_apart(CloudViewLayer shell, float from, float to) {
    return smoothstep(CIRRUS_ALONG, CIRRUS_ALL_ALONG, (to - from) * shell.per_thickness);
}

int cirrus_places(float apart) {
    return apart > 0.0 ? CIRRUS_PLACES : 1;
}

// Metres along the ray.
float cirrus_place(float from, float to, float apart, int place) {
    float share = (float(place) + 0.5) / float(cirrus_places(apart));
    return mix(from, to, mix(0.5, share, apart));
}

// Metres along the ray: segments grow geometrically with distance.
float segment_end(CloudViewLayer shell, float from, float to, int segment, float segments) {
    // With skipped space: even segments, in digits that f32 has.
    float thickness = shell.top_m - shell.base_m + min(ray_skipped_m, 10.0 * (to - from));
    float growth = log((to + thickness) / (from + thickness)) / segments;
    return float(segment + 1) >= segments ? to : (from + thickness) * exp(growth * float(segment + 1)) - thickness;
}

// The weather t metres along a ray. A pixel that sees the clouds at a low angle stands for a long way through them: its
// footprint is the geometric mean of its width and its length, or rows of pixels near the limb would fall on clouds and
// on gaps by chance.
CloudWeather weather_along(vec3 ray, float t) {
    vec3 up = up_at(ray * t);
    float lengthening = inversesqrt(max(abs(dot(ray, up)), LEAST_MU));
    return cloud_weather(up, (t + ray_skipped_m) * pixel_rad * lengthening);
}
