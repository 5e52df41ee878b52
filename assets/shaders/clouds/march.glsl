// Light along one ray through air and clouds at once: segments between all heights where something begins or ends, and
// steps in each that are short where light comes from (docs/clouds.md, "The march through homogeneous layers").
//
// Defines: CLOUD_STEPS and CLOUD_AIR_STEPS (steps of a segment in cloud, in clear air), CLOUD_DEEPEST (optical depth
// beyond which nothing is seen), and those of clouds/scattered.glsl. Whoever includes this defines cloud_extinction(),
// cloud_sun_depth() and cloud_column(); clouds/uniform_march.glsl does it for homogeneous shells.
#include "clouds/step.glsl"
#include "clouds/scattered.glsl"
#include "contract/air_point.glsl"

const int CLOUD_MOST_TURNS = 4096;

struct CloudRay {
    ShellRay shell;
    float rise;             // m: the start's coordinate along the sun's direction, from the planet's centre
    float nu;               // cosine between ray and sun
    float sun_radius_rad;   // 0: a point
    float multiple;         // 1: all orders of scattering; 0: the first
};

// Per metre, of one layer that the point lies in; share: of its height.
float cloud_extinction(int layer, CloudRay ray, float t, float share);

// Optical depth of all clouds from a point of the ray to space; sun: the ray from there to the sun.
float cloud_sun_depth(CloudRay ray, float t, ShellRay sun);

// Vertical optical depth of all clouds above and below that point.
vec2 cloud_column(CloudRay ray, float t, float h);

// Visible share of the sun over the reference sphere, as common/sun_visibility.glsl has it (Bruneton 2017).
float cloud_sun_visibility(ShellRay sun, float sun_radius_rad) {
    if (sun_radius_rad <= 0.0) return sun.b >= 0.0 || sun.perigee >= 0.0 ? 1.0 : 0.0;
    float h = max(sun.h, 0.0), there = shell_radius() + h;
    float soft = sun_radius_rad * shell_radius();
    return smoothstep(-soft, soft, sun.b + safe_sqrt(shell_between(h, 0.0)));
}

// The next distance after `from` where something begins or ends: a layer, the way down, the planet's shadow, or a layer
// on the way to the sun.
float next_boundary(CloudRay ray, float from, float end) {
    float least = from + max(3e-7 * from, 1e-6), next = end;
    vec2 shadow_edges = shell_tangents(ray.shell, ray.rise, ray.nu, 0.0);
    vec4 at = vec4(-ray.shell.b, shadow_edges, end);
    for (int k = 0; k < 4; ++k) if (at[k] > least) next = min(next, at[k]);
    for (int layer = 0; layer < cloud_model.layer_count; ++layer) {
        CloudModelLayer shell = cloud_model.layers[layer];
        at = shell_intervals(ray.shell, shell.base_m, shell.top_m);
        for (int k = 0; k < 4; ++k) if (at[k] > least) next = min(next, at[k]);
        at = vec4(shell_tangents(ray.shell, ray.rise, ray.nu, shell.base_m),
            shell_tangents(ray.shell, ray.rise, ray.nu, shell.top_m));
        for (int k = 0; k < 4; ++k) if (at[k] > least) next = min(next, at[k]);
    }
    return next;
}

// Layers that a distance lies in, one bit each.
int layer_mask_at(CloudRay ray, float t) {
    int found = 0;
    for (int layer = 0; layer < cloud_model.layer_count; ++layer) {
        vec4 intervals = shell_intervals(ray.shell, cloud_model.layers[layer].base_m, cloud_model.layers[layer].top_m);
        bool inside = (t > intervals.x && t < intervals.y) || (t > intervals.z && t < intervals.w);
        if (inside) found |= 1 << layer;
    }
    return found;
}

// How far into a segment of cloud a share of its steps leads: steps grow from both ends, geometrically beyond `first`
// metres. Light from thick cloud comes out of its first optical depths, or, where it thins towards the sun, of its
// last.
float cloud_step_begin(float share, float length_m, float first) {
    float x = 1.0 - abs(2.0 * share - 1.0), growth = log(1.0 + 0.5 * length_m / first);
    float away = first * (exp(x * growth) - 1.0);
    return clamp(share < 0.5 ? away : length_m - away, 0.0, length_m);
}

// How long the first and last steps of a segment should be, for a length `free` over which cloud dims light by a third.
// Under a low sun light dims on a much shorter way down than that: by free |mu_s|, or as far as the planet's curve
// drops.
float shortest_step(CloudRay ray, float from, float to, float free) {
    float r = shell_radius() + ray.shell.h, a = ray.rise + ray.nu * from, b = ray.rise + ray.nu * to;
    float low = a * b <= 0.0 ? 0.0 : min(abs(a), abs(b)) / r;
    return min(free, free * low + 0.5 * free * free / r);
}

// The same in clear air: dense at the lower end.
float air_step_begin(float share, float length_m, bool down) {
    float x = down ? 1.0 - share : share;
    return length_m * (down ? 1.0 - x * x : x * x);
}

// Light of the sky that droplets scatter: it comes from above, and goes down as far as they let it (Eddington's
// approximation of a slab that is lit from above, over dark ground).
vec3 cloud_ambient(int layer, vec2 column, vec3 ambient) {
    float turned = 1.0 - cloud_model.layers[layer].asymmetry;
    return ambient * (turned * column.y + 2.0 / 3.0) / (turned * (column.x + column.y) + 4.0 / 3.0);
}

// before: optical depth of clouds between the camera and the step; into_step: how far into the step the point lies.
MediumSample medium_at(CloudRay ray, int layers, float t, float before, float into_step) {
    float h = shell_height(ray.shell, t);
    ShellRay sun = shell_sun_ray(h, ray.rise + ray.nu * t);
    float visibility = cloud_sun_visibility(sun, ray.sun_radius_rad), there = shell_radius() + h;
    float mu = clamp_cos((ray.shell.b + t) / there), mu_s = clamp_cos(sun.b / there),
        cloud_depth = cloud_sun_depth(ray, t, sun);
    AirPoint air = air_point(h, mu, mu_s, ray.nu, ray.multiple);
    MediumSample medium = MediumSample(air.extinction, air.sun_depth + cloud_depth, visibility * air.direct,
        air.diffuse, 0.0, 0.0);
    vec3 sunlight = visibility * exp(-air.sun_depth);
    float direct = 0.0, gained = 0.0;
    vec2 column = ray.multiple > 0.0 && layers != 0 ? cloud_column(ray, t, h) : vec2(0.0);
    for (int layer = 0; layer < cloud_model.layer_count; ++layer) {
        if ((layers & (1 << layer)) == 0) continue;
        float share = clamp(cloud_share(layer, h), 0.0, 1.0), extinction = cloud_extinction(layer, ray, t, share);
        float albedo = cloud_model.layers[layer].albedo,
            once = albedo * cloud_phase(ray.nu, cloud_model.layers[layer].asymmetry);
        float lobes = 1.0;
        medium.cloud += extinction;
        if (ray.multiple > 0.0) {
            medium.forward += extinction * cloud_peak(layer);
            lobes = cloud_lobes(layer, ray.nu, before + into_step * extinction + cloud_depth);
            medium.diffuse += extinction * (sunlight * cloud_slab(layer, column.x, column.y, mu, mu_s, ray.nu)
                + (albedo - cloud_peak(layer)) * cloud_ambient(layer, column, air.ambient));
        }
        direct += visibility * extinction * once;
        gained += visibility * extinction * once * lobes;
    }
    medium.extinction += medium.cloud;
    // Lobes make sunlight fall more slowly than exp(-depth): they belong to the exponent, which is followed along a
    // step.
    vec3 total = medium.direct + direct, more = medium.direct + gained;
    medium.sun_depth -= log(mix(vec3(1.0), more / max(total, 1e-30), greaterThan(total, vec3(1e-30))));
    medium.direct = total;
    return medium;
}

// Between two boundaries, in metres along the ray.
struct MarchSegment {
    float from, to, shortest;   // the latter: of its steps in cloud
    int layers, steps;          // bits of the layers that it lies in
    bool down;                  // towards the planet
};

MarchSegment segment_from(CloudRay ray, float from, float end) {
    float to = next_boundary(ray, from, end), middle = 0.5 * (from + to), thickest = 1e-12;
    int layers = layer_mask_at(ray, middle);
    for (int layer = 0; layer < cloud_model.layer_count; ++layer) {
        if ((layers & (1 << layer)) != 0) thickest += cloud_model.layers[layer].extinction_per_m;
    }
    return MarchSegment(from, to, min(shortest_step(ray, from, to, 0.5 / thickest), to - from), layers,
        layers != 0 ? CLOUD_STEPS : CLOUD_AIR_STEPS, ray.shell.b + middle < 0.0);
}

// Where a step begins, in metres from the segment's begin.
float step_begin(MarchSegment s, int index) {
    float share = float(index) / float(s.steps), length_m = s.to - s.from;
    return s.layers != 0 ? cloud_step_begin(share, length_m, s.shortest) : air_step_begin(share, length_m, s.down);
}

// Up to a distance `end` from the ray's start, which lies below the highest thing there is (shell_enter).
CloudLight cloud_march(CloudRay ray, float end) {
    CloudLight light = CloudLight(vec3(0.0), vec3(0.0), 0.0, 0.0);
    MarchSegment s = MarchSegment(0.0, 0.0, 1.0, 0, 0, false);
    int index = 0;
    // One loop over all steps of all segments: lanes that have less to do don't wait in each.
    for (int turn = 0; turn < CLOUD_MOST_TURNS; ++turn) {
        if (index == s.steps) {
            if (s.to >= end || min(min(light.depth.r, light.depth.g), light.depth.b) > CLOUD_DEEPEST) break;
            s = segment_from(ray, s.to, end);
            index = 0;
        }
        float begin = step_begin(s, index), length_m = step_begin(s, index + 1) - begin;
        float past_a = GAUSS_A * length_m, past_b = GAUSS_B * length_m;
        MediumSample a = medium_at(ray, s.layers, s.from + begin + past_a, light.cloud, past_a);
        MediumSample b = medium_at(ray, s.layers, s.from + begin + past_b, light.cloud, past_b);
        cloud_step(light, length_m, a, b);
        ++index;
    }
    return light;
}
