// One map of the clouds' shadow. A texel is a ray of the sun, at the place where it crosses the reference height; it is
// followed from the top of the clouds down. Kept are, for the ground, what comes through all of them, and the beam and
// the optical depth that are left at each of a few heights, for the air and for clouds.
#include "generated/bindings.glsl"
#include "clouds/density.glsl"
#include "clouds/sun_ray.glsl"
#include "clouds/slab_transmittance.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, rgba16f) uniform writeonly image2DArray o_shadow;
layout(binding = 1, rg16f) uniform writeonly image3D o_sun;
// per map, and of the one that is made: whether anything in it is
layout(std430, binding = CLOUD_SHADED_BUFFER) buffer Shaded { uint shaded[]; };
layout(location = 0) uniform int u_layer;    // of o_shadow
layout(location = 1) uniform int u_steps;    // through an interval
layout(location = 2) uniform vec3 u_middle_m; // of the map, from the anchor in planet axes, at the reference height
layout(location = 3) uniform vec3 u_up;       // there
layout(location = 4) uniform vec3 u_along;    // its axes, the first divided by that
layout(location = 5) uniform vec3 u_across;
layout(location = 6) uniform vec3 u_sun;      // when it was begun
layout(location = 7) uniform ivec2 u_rows;    // from and to
layout(location = 8) uniform int u_first;     // slice of o_sun
layout(location = 9) uniform float u_half_m;  // half width of the map
layout(location = 10) uniform float u_longer; // how many times longer than wide it is
layout(location = 11) uniform vec2 u_intervals[CLOUD_MOST_INTERVALS];   // heights from and to, lowest first

const float DEEPEST = 6e4;      // half floats end at 65504
const int MOST_SPLIT = 8;
const float SHADED = 0.002;     // optical depth that counts

// The lowest and the highest layer of water that have part of an interval of heights, mostly one; x above y: none.
ivec2 layers_between(vec2 heights) {
    int lowest = cloud_view.layer_count, highest = 0, layer = 0;
    do {
        bool part = cloud_view.layers[layer].base_m < heights.y && cloud_view.layers[layer].top_m > heights.x
            && !CLOUD_IS_CIRRUS(layer);
        lowest = part ? min(lowest, layer) : lowest;
        highest = part ? layer : highest;
    } while (++layer < cloud_view.layer_count);
    return ivec2(lowest, highest);
}

// Optical depth of a sheet of ice along the whole ray, which crosses its middle in `middle` metres.
float sheet_depth(int layer, vec3 place, vec3 foot, float middle, float through, float footprint) {
    CloudViewLayer shell = cloud_view.layers[layer];
    vec3 way = u_sun * middle;
    return shell.extinction_per_m * through * cirrus_filled(shell, vec2(0.0, 1.0))
        * cirrus_density(layer, place + way, cloud_weather(normalize(foot + way), footprint), footprint);
}

// How much of that lies between two heights.
float sheet_share(CloudViewLayer shell, vec2 heights) {
    vec2 shares = clamp((heights - shell.base_m) * shell.per_thickness, 0.0, 1.0);
    return (shares.y - shares.x) * cirrus_filled(shell, shares) / cirrus_filled(shell, vec2(0.0, 1.0));
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, u_rows.x);
    ivec2 size = imageSize(o_shadow).xy;
    if (any(greaterThanEqual(at, ivec2(size.x, u_rows.y)))) return;
    vec2 aside = ((vec2(at) + 0.5) / vec2(size) * 2.0 - 1.0) * u_half_m;
    // On the sphere of the reference height, below the tangent plane by the sagitta; far out it ends.
    float r = planet.radius_m + cloud_view.shadow_height_m, grow = r / planet.radius_m;
    aside *= grow * vec2(u_longer, 1.0);
    float aside2 = min(dot(aside, aside), 0.98 * r * r);
    float drop = aside2 / (r + sqrt(r * r - aside2));
    vec3 from_middle = aside.x * u_longer * u_along + aside.y * u_across;
    vec3 place = u_middle_m + from_middle - u_up * drop;
    vec3 foot = u_up * (r - drop) + from_middle, sun = u_sun;
    float mu = dot(normalize(foot), sun), footprint = 2.0 * u_half_m / float(size.x);
    int intervals = cloud_view.shadow_intervals, first = u_first;
    float depth = 0.0;
    imageStore(o_sun, ivec3(at, first + intervals), vec4(1.0, 0.0, 0.0, 0.0));
    float sheets[CLOUD_VIEW_LAYERS];
    int sheet = 0;
    do {
        CloudViewLayer shell = cloud_view.layers[sheet];
        vec2 ends = vec2(distance_to_rise(r, mu, shell.base_m - cloud_view.shadow_height_m),
            distance_to_rise(r, mu, shell.top_m - cloud_view.shadow_height_m));
        sheets[sheet] = CLOUD_IS_CIRRUS(sheet)
            ? sheet_depth(sheet, place, foot, 0.5 * (ends.x + ends.y), ends.y - ends.x, footprint) : 0.0;
    } while (++sheet < cloud_view.layer_count);
    // Loops are left at their ends: software GPUs go through the turn, too, in which one is left at its head.
    int i = intervals - 1;
    do {
        vec2 heights = u_intervals[i];
        float from = distance_to_rise(r, mu, heights.y - cloud_view.shadow_height_m);
        // Under a low sun the way is long: in longer steps clouds and gaps would be taken together.
        float whole_m = from - distance_to_rise(r, mu, heights.x - cloud_view.shadow_height_m);
        int steps = u_steps * clamp(int(0.5 * whole_m / (float(u_steps) * footprint)), 1, MOST_SPLIT), k = 0;
        ivec2 layers = layers_between(heights);
        bool water = layers.x <= layers.y;
        steps = water ? steps : 1;
        do {
            float share = (float(k) + 1.0) / float(steps), lower = mix(heights.y, heights.x, share);
            float height = mix(heights.y, heights.x, share - 0.5 / float(steps));
            float to = distance_to_rise(r, mu, lower - cloud_view.shadow_height_m), path_m = max(from - to, 0.0),
                middle = 0.5 * (from + to);
            float width_m = max(footprint, 0.35 * path_m);
            CloudWeather w = cloud_weather(normalize(foot + sun * middle), width_m);
            int layer = min(layers.x, cloud_view.layer_count - 1);
            do {
                CloudViewLayer shell = cloud_view.layers[layer];
                float within = (height - shell.base_m) * shell.per_thickness;
                float found = cloud_density(layer, place + sun * middle, clamp(within, 0.0, 1.0), w, width_m, 0);
                depth += water && within > 0.0 && within < 1.0 && !CLOUD_IS_CIRRUS(layer)
                    ? shell.extinction_per_m * path_m * found : 0.0;
            } while (++layer <= layers.y);
            from = to;
        } while (++k < steps);
        sheet = 0;
        do depth += sheets[sheet] * sheet_share(cloud_view.layers[sheet], heights);
        while (++sheet < cloud_view.layer_count);
        imageStore(o_sun, ivec3(at, first + i), vec4(exp(-depth), min(depth, DEEPEST), 0.0, 0.0));
    } while (--i >= 0);
    if (depth > SHADED) shaded[u_layer] = 1u;
    imageStore(o_shadow, ivec3(at, u_layer), slab_transmittance(depth, max(mu, 0.0), cloud_view.layers[0].asymmetry));
}
