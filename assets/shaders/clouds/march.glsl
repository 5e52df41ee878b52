// Light along one ray through air and clouds at once: segments between all heights where something begins or ends, and
// steps in each that are short where light comes from.
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
    float rise;    // the start's coordinate along the sun's direction, from the planet's centre
    float nu;      // cosine between ray and sun
    float disc;    // the sun's angular radius; 0: a point
    float multiple;   // 1: light scattered more than once counts; 0: single scattering
};

// Per metre, of one layer that the point lies in; share: of its height.
float cloud_extinction(int layer, CloudRay ray, float t, float share);

// Optical depth of all clouds from a point of the ray to space; sun: the ray from there to the sun.
float cloud_sun_depth(CloudRay ray, float t, ShellRay sun);

// Vertical optical depth of all clouds above and below that point.
vec2 cloud_column(CloudRay ray, float t, float h);

// Visible share of the sun over the reference sphere, as common/sun_visibility.glsl has it (Bruneton 2017).
float cloud_sun_share(ShellRay sun, float disc) {
    if (disc <= 0.0) return sun.b >= 0.0 || sun.perigee >= 0.0 ? 1.0 : 0.0;
    float h = max(sun.h, 0.0), there = shell_radius() + h;
    float soft = disc * shell_radius();
    return smoothstep(-soft, soft, sun.b + safe_sqrt(shell_between(h, 0.0)));
}

// The next distance after `from` where something begins or ends: a layer, the way down, the planet's shadow, or a layer
// on the way to the sun.
float cloud_next_edge(CloudRay ray, float from, float end) {
    float least = from + max(3e-7 * from, 1e-6), next = end;
    vec2 seen = shell_tangents(ray.shell, ray.rise, ray.nu, 0.0);
    vec4 at = vec4(-ray.shell.b, seen, end);
    for (int k = 0; k < 4; ++k) if (at[k] > least) next = min(next, at[k]);
    for (int layer = 0; layer < cloud_model.layer_count; ++layer) {
        CloudModelLayer shell = cloud_model.layers[layer];
        at = shell_spans(ray.shell, shell.base_m, shell.top_m);
        for (int k = 0; k < 4; ++k) if (at[k] > least) next = min(next, at[k]);
        at = vec4(shell_tangents(ray.shell, ray.rise, ray.nu, shell.base_m),
            shell_tangents(ray.shell, ray.rise, ray.nu, shell.top_m));
        for (int k = 0; k < 4; ++k) if (at[k] > least) next = min(next, at[k]);
    }
    return next;
}

// Layers that a distance lies in, one bit each.
int cloud_layers_at(CloudRay ray, float t) {
    int found = 0;
    for (int layer = 0; layer < cloud_model.layer_count; ++layer) {
        vec4 spans = shell_spans(ray.shell, cloud_model.layers[layer].base_m, cloud_model.layers[layer].top_m);
        bool inside = (t > spans.x && t < spans.y) || (t > spans.z && t < spans.w);
        if (inside) found |= 1 << layer;
    }
    return found;
}

// How far into a segment of cloud a share of its steps leads: steps grow from both ends, geometrically beyond `first`
// metres. Light from thick cloud comes out of its first optical depths, or, where it thins towards the sun, of its
// last.
float cloud_spread(float share, float length_m, float first) {
    float x = 1.0 - abs(2.0 * share - 1.0), growth = log(1.0 + 0.5 * length_m / first);
    float away = first * (exp(x * growth) - 1.0);
    return clamp(share < 0.5 ? away : length_m - away, 0.0, length_m);
}

// How long the first and last steps of a segment should be, for a length `free` over which cloud dims light by a third.
// Under a low sun light dims on a much shorter way down than that: by free |mu_s|, or as far as the planet's curve
// drops.
float cloud_first(CloudRay ray, float from, float to, float free) {
    float r = shell_radius() + ray.shell.h, a = ray.rise + ray.nu * from, b = ray.rise + ray.nu * to;
    float low = a * b <= 0.0 ? 0.0 : min(abs(a), abs(b)) / r;
    return min(free, free * low + 0.5 * free * free / r);
}

// The same in clear air: dense at the lower end.
float cloud_air_spread(float share, float length_m, bool down) {
    float x = down ? 1.0 - share : share;
    return length_m * (down ? 1.0 - x * x : x * x);
}

// Light of the sky that droplets scatter: it comes from above, and goes down as far as they let it (Eddington's
// approximation of a slab that is lit from above, over dark ground).
vec3 cloud_ambient(int layer, vec2 column, vec3 ambient) {
    float turned = 1.0 - cloud_model.layers[layer].asymmetry;
    return ambient * (turned * column.y + 2.0 / 3.0) / (turned * (column.x + column.y) + 4.0 / 3.0);
}

// before: optical depth of clouds between the camera and the step; past: how far into the step the point lies.
CloudNode cloud_node(CloudRay ray, int layers, float t, float before, float past) {
    float h = shell_height(ray.shell, t);
    ShellRay sun = shell_sun_ray(h, ray.rise + ray.nu * t);
    float seen = cloud_sun_share(sun, ray.disc), there = shell_radius() + h;
    float mu = clamp_cos((ray.shell.b + t) / there), mu_s = clamp_cos(sun.b / there),
        cloud_depth = cloud_sun_depth(ray, t, sun);
    AirPoint air = air_point(h, mu, mu_s, ray.nu, ray.multiple);
    CloudNode node = CloudNode(air.extinction, air.sun_depth + cloud_depth, seen * air.direct, air.diffuse, 0.0, 0.0);
    vec3 sunlight = seen * exp(-air.sun_depth);
    float direct = 0.0, gained = 0.0;
    vec2 column = ray.multiple > 0.0 && layers != 0 ? cloud_column(ray, t, h) : vec2(0.0);
    for (int layer = 0; layer < cloud_model.layer_count; ++layer) {
        if ((layers & (1 << layer)) == 0) continue;
        float share = clamp(cloud_share(layer, h), 0.0, 1.0), extinction = cloud_extinction(layer, ray, t, share);
        float albedo = cloud_model.layers[layer].albedo,
            once = albedo * cloud_phase(ray.nu, cloud_model.layers[layer].asymmetry);
        float lobes = 1.0;
        node.cloud += extinction;
        if (ray.multiple > 0.0) {
            node.relief += extinction * cloud_peak(layer);
            lobes = cloud_lobes(layer, ray.nu, before + past * extinction + cloud_depth);
            node.diffuse += extinction * (sunlight * cloud_slab(layer, column.x, column.y, mu, mu_s, ray.nu)
                + (albedo - cloud_peak(layer)) * cloud_ambient(layer, column, air.ambient));
        }
        direct += seen * extinction * once;
        gained += seen * extinction * once * lobes;
    }
    node.extinction += node.cloud;
    // Lobes make sunlight fall more slowly than exp(-depth): they belong to the exponent, which is followed along a
    // step.
    vec3 all = node.direct + direct, more = node.direct + gained;
    node.sun_depth -= log(mix(vec3(1.0), more / max(all, 1e-30), greaterThan(all, vec3(1e-30))));
    node.direct = all;
    return node;
}

// Up to a distance `end` from the ray's start, which lies below the highest thing there is (shell_enter).
CloudLight cloud_march(CloudRay ray, float end) {
    CloudLight light = CloudLight(vec3(0.0), vec3(0.0), 0.0, 0.0);
    float from = 0.0, to = 0.0, first = 1.0;
    int step = 0, steps = 0, layers = 0;
    bool down = false;
    // One loop over all steps of all segments: lanes that have less to do don't wait in each.
    for (int turn = 0; turn < CLOUD_MOST_TURNS; ++turn) {
        if (step == steps) {
            from = to;
            if (from >= end || min(min(light.depth.r, light.depth.g), light.depth.b) > CLOUD_DEEPEST) break;
            to = cloud_next_edge(ray, from, end);
            float middle = 0.5 * (from + to);
            layers = cloud_layers_at(ray, middle);
            down = ray.shell.b + middle < 0.0;
            step = 0;
            steps = layers != 0 ? CLOUD_STEPS : CLOUD_AIR_STEPS;
            float thickest = 1e-12;
            for (int layer = 0; layer < cloud_model.layer_count; ++layer) {
                if ((layers & (1 << layer)) != 0) thickest += cloud_model.layers[layer].extinction_per_m;
            }
            first = min(cloud_first(ray, from, to, 0.5 / thickest), to - from);
        }
        float a = float(step) / float(steps), b = float(step + 1) / float(steps), length_m = to - from;
        float ta = layers != 0 ? cloud_spread(a, length_m, first) : cloud_air_spread(a, length_m, down);
        float tb = layers != 0 ? cloud_spread(b, length_m, first) : cloud_air_spread(b, length_m, down);
        float past_a = CLOUD_NODE_A * (tb - ta), past_b = CLOUD_NODE_B * (tb - ta);
        CloudNode near = cloud_node(ray, layers, from + ta + past_a, light.cloud, past_a);
        CloudNode far = cloud_node(ray, layers, from + ta + past_b, light.cloud, past_b);
        cloud_step(light, tb - ta, near, far);
        ++step;
    }
    return light;
}
