// The printed march through clouds and air (Michelic 2018, section 5; Michelic et al. 2019, section 3), as it is
// printed: with Riemann sums, six samples towards the sun, a sun that no air dims, and light scattered once. There to
// compare with.
//
// Defines: CLOUD_PAPER (2018 or 2019: how clouds and air are put together). What a source does not say: steps are a
// fortieth of the layer's thickness and sampled in their middles, the six samples share the way to the layer's top,
// segments of air inside the layer begin with a quarter of its thickness and grow by a quarter each.
#include "clouds/march.glsl"

const int PAPER_STEPS = 40, PAPER_SUN_SAMPLES = 6, PAPER_AIR_SLICES = 8, PAPER_MOST_SEGMENTS = 96,
    PAPER_MOST_STEPS = 4096;

// Transmittance and light of clear air between two distances: what the sources look up in tables.
CloudLight paper_air(CloudRay ray, float from, float to) {
    CloudLight light = CloudLight(vec3(0.0), vec3(0.0), 0.0, 0.0);
    float dt = (to - from) / float(PAPER_AIR_SLICES);
    for (int i = 0; i < PAPER_AIR_SLICES; ++i) {
        MediumSample medium[2];
        for (int k = 0; k < 2; ++k) {
            float t = from + dt * (float(i) + (k == 0 ? GAUSS_A : GAUSS_B)), h = shell_height(ray.shell, t);
            ShellRay sun = shell_sun_ray(h, ray.rise + ray.nu * t);
            float there = shell_radius() + h;
            AirPoint air = air_point(h, clamp_cos((ray.shell.b + t) / there), clamp_cos(sun.b / there), ray.nu, 0.0);
            medium[k] = MediumSample(air.extinction, air.sun_depth,
                cloud_sun_visibility(sun, ray.sun_radius_rad) * air.direct, vec3(0.0), 0.0, 0.0);
        }
        cloud_step(light, dt, medium[0], medium[1]);
    }
    return light;
}

// Equation 14 times the extinction, where the texture is 1.
float paper_density(CloudRay ray, int layer, float h) {
    return cloud_model.layers[layer].extinction_per_m * cloud_profile(layer, cloud_share(layer, h));
}

float paper_sun(CloudRay ray, int layer, float t) {
    float h = shell_height(ray.shell, t);
    ShellRay sun = shell_sun_ray(h, ray.rise + ray.nu * t);
    float step_m = shell_ball(sun, cloud_model.layers[layer].top_m).y / float(PAPER_SUN_SAMPLES), transmittance = 1.0;
    for (int i = 0; i < PAPER_SUN_SAMPLES; ++i) {
        transmittance *= exp(-step_m * paper_density(ray, layer, shell_height(sun, step_m * (float(i) + 0.5))));
    }
    return transmittance * cloud_sun_visibility(sun, ray.sun_radius_rad);
}

// One segment between two samples of the air; transmittance: of all before it.
void paper_segment(inout vec3 radiance, inout vec3 transmittance, CloudRay ray, int layer, float from, float to) {
    CloudLight clear = paper_air(ray, from, to);
    vec3 air = exp(-clear.depth), together = vec3(0.0);
    CloudModelLayer shell = cloud_model.layers[layer];
    float cloud = 1.0, alone = 0.0, length_m = (shell.top_m - shell.base_m) / float(PAPER_STEPS);
    int steps = clamp(int(ceil((to - from) / length_m)), 1, PAPER_MOST_STEPS);
    length_m = (to - from) / float(steps);
    for (int i = 0; i < steps; ++i) {
        float share = (float(i) + 0.5) / float(steps), t = mix(from, to, share);
        float taken = length_m * paper_density(ray, layer, shell_height(ray.shell, t));
        // (15)
        cloud *= exp(-taken);
        // (16)
        float light = shell.albedo * cloud_phase(ray.nu, shell.asymmetry) * taken * paper_sun(ray, layer, t) * cloud;
        alone += light;
        // 2019: the air's light comes evenly along the segment, and its transmittance runs linearly.
        together += clear.radiance / float(steps) * cloud + light * mix(vec3(1.0), air, share);
    }
#if CLOUD_PAPER == 2018
    // (20)
    radiance += transmittance * (clear.radiance * cloud + alone);
#else
    radiance += transmittance * together;
#endif
    // (19)
    transmittance *= air * cloud;
}

void paper_clear(inout vec3 radiance, inout vec3 transmittance, CloudRay ray, float from, float to) {
    if (to <= from) return;
    CloudLight clear = paper_air(ray, from, to);
    radiance += transmittance * clear.radiance;
    transmittance *= exp(-clear.depth);
}

// Like cloud_march, through the first layer alone: the sources have one.
CloudLight paper_march(CloudRay ray, float end) {
    vec3 radiance = vec3(0.0), transmittance = vec3(1.0);
    vec4 intervals = vec4(0.0);
    float thickness = 1.0;
    if (cloud_model.layer_count > 0) {
        intervals = min(shell_intervals(ray.shell, cloud_model.layers[0].base_m, cloud_model.layers[0].top_m), end);
        thickness = cloud_model.layers[0].top_m - cloud_model.layers[0].base_m;
    }
    float t = 0.0;
    for (int k = 0; k < 2; ++k) {
        float from = intervals[2 * k], to = intervals[2 * k + 1];
        if (to <= from) continue;
        paper_clear(radiance, transmittance, ray, t, from);
        float length_m = 0.25 * thickness;
        t = from;
        for (int i = 0; i < PAPER_MOST_SEGMENTS && t < to; ++i) {
            float next = i == PAPER_MOST_SEGMENTS - 1 ? to : min(t + length_m, to);
            paper_segment(radiance, transmittance, ray, 0, t, next);
            t = next;
            length_m *= 1.25;
            if (max(max(transmittance.r, transmittance.g), transmittance.b) < 1e-7) break;
        }
        t = to;
    }
    paper_clear(radiance, transmittance, ray, t, end);
    return CloudLight(radiance, -log(max(transmittance, 1e-37)), 0.0, 0.0);
}
