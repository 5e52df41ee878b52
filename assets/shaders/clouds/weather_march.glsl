// The march along one ray through the layers of cloud that follow the weather, with the air in front and between.
//
//   March march_clouds(vec3 ray, float mu, float end, float jitter)
//
// ray: unit, from the camera; mu: its cosine to the zenith; end: how far it goes; jitter: 0..1, of the samples in their
// steps. Whoever includes this sets pixel_rad and cloud_dither first. Without air in front:
// out = transmittance * picture (its own air included) + radiance.
//
// The transfer equation, step by step: dL = T (1 - exp(-tau)) S, with the source S of single scattering (Henyey and
// Greenstein), of lobes of the forward peak, and of light that was scattered before (docs/clouds.md, "Light that is
// scattered more than once"). How steps are chosen and what the segments' air does: docs/cloud-pictures.md, "March".
#include "clouds/run_light.glsl"
#include "clouds/step_size.glsl"
#include "clouds/sun_optical_depth.glsl"
#include "clouds/cirrus_march.glsl"

// Steps through the clear, until rays beside one another wait for those in cloud.
const int CLEAR_STEPS = 5;

// Where a ray is: the next step's begin in metres, and its length in short steps, above 1 through the clear; share of
// that length: 1 but for a segment's first step.
struct Cursor {
    float t, factor, share;
};

// One sample of density: of a step's noise, before the rims. footprint: in metres.
struct Sample {
    CloudNoise noise;
    float gap;                          // of the noise to any cloud; 0: there may be some
    float step_m, short_m, share, footprint;   // share: of the layer's height
};

// Share of a step of optical depth `depth` after which a photon is scattered, for a chance of 0..1: the inverse of the
// distribution exp(-depth x) / (1 - exp(-depth)).
float free_path_share(float depth, float chance) {
    return depth < 0.02 ? chance : -log(1.0 - chance * (1.0 - exp(-depth))) / depth;
}

// Finest steps ask the maps of weather at each place.
CloudWeather weather_at(Segment s, float t, vec3 point) {
#ifdef CLOUD_FINEST
    return cloud_weather(up_at(point), (t + ray_skipped_m) * pixel_rad);
#else
    return cloud_weather_between(s.near_weather, s.far_weather, (t - s.begin) * s.per_metre);
#endif
}

float sample_footprint(float t, float short_m) {
    return max((t + ray_skipped_m) * pixel_rad, 0.2 * short_m);
}

Sample density_sample(LayerRay r, StepSizes sizes, Segment s, Cursor at, float last, float longest, float occluded) {
    Sample found;
    found.short_m = step_size(sizes, at.t, r.from, r.to, occluded);
    found.step_m = clamp(last - at.t + 1e-3, 0.0,
        at.share * min(found.short_m * at.factor, max(found.short_m, longest)));
    float t = at.t + r.jitter * found.step_m;
    vec3 point = r.ray * t;
    found.share = clamp((altitude_of(point) - r.shell.base_m) * r.shell.per_thickness, 0.0, 1.0);
    found.footprint = sample_footprint(t, found.short_m);
    found.noise = cloud_noise(r.layer, point + frame.camera_offset_m, found.share, weather_at(s, t, point),
        found.footprint);
    found.gap = cloud_gap(r.layer, found.noise, found.footprint);
    return found;
}

// Through the clear and into cloud, apart from its light, so that rays in the clear don't pay for that. Long steps
// through the clear; where there is cloud, back to the last clear place and on in short ones. last: where clouds end;
// longest: step through the clear. air_seen, with CLOUD_FINEST: metres, each times the transmittance before it.
CloudRun next_run(
    inout March m, inout Cursor at, inout float air_seen, LayerRay r, StepSizes sizes, Segment s, float last,
    float longest
) {
    CloudRun run = CloudRun(0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    float weight = 0.0, occluded = 1.0 + sizes.occluded_factor * (1.0 - m.transmittance);
    // Five; but not to a compiler, which would write all that a sample does five times over.
    int steps = 0, most_clear = min(CLEAR_STEPS, CLEAR_STEPS * int(u_layer_steps));
    bool on_in;
    do {
        Sample here;
        int clear_steps = 0;
        do {
            here = density_sample(r, sizes, s, at, last, longest, occluded);
            at.share = 1.0;
            m.samples += 1.0;
            // Surely clear: on, without a look at the rims.
            at.t += here.gap > 0.0 ? here.step_m : 0.0;
            at.factor = here.gap > 0.0
                ? min(at.factor * CLEAR_GROWTH, sizes.clear_factor) * (1.0 + sizes.clear_gap_factor * here.gap)
                : at.factor;
#ifdef CLOUD_FINEST
            air_seen += here.gap > 0.0 ? m.transmittance * here.step_m : 0.0;
#endif
        } while (here.gap > 0.0 && run.depth <= 0.0 && at.t < last && ++clear_steps < most_clear);
        bool near = here.gap <= 0.0;
        float density = near ? cloud_rimmed(r.layer, here.noise, here.share, here.footprint, 2) : 0.0;
        // In cloud: the same way again, in short steps; or on.
        bool found = density > LEAST_DENSITY, again = found && at.factor > 1.0;
        float on = again || !near ? 0.0 : here.step_m,
            depth = found ? r.shell.extinction_per_m * density * on : 0.0;
#ifdef CLOUD_FINEST
        air_seen += m.transmittance * on;
#endif
        // Light is sampled where a step is seen: the thicker it is, the nearer to its begin.
        float opacity = exp(-run.depth) * depth * one_minus_exp_over(depth), within = free_path_share(depth, r.jitter);
        run.t += opacity * (at.t + on * within);
        run.depth_before += opacity * (run.depth + depth * within);
        run.column += opacity * cloud_own_column(r.layer, here.noise);
        weight += opacity;
        run.depth += depth;
        at.t += on;
        at.factor = found ? 1.0 : near ? min(at.factor * CLEAR_GROWTH, sizes.clear_factor) : at.factor;
        steps += on > 0.0 && found ? 1 : 0;
        run.length_m += found ? on : 0.0;
        run.short_m = here.short_m;
        on_in = run.depth <= sizes.shared_depth * occluded && float(steps) < sizes.shared_steps * occluded
            && (found || run.depth <= 0.0);
    } while (at.t < last && on_in);
    run.t /= weight;
    run.column /= weight;
    run.depth_before /= weight;
    return run;
}

// Of a cloud whose weather is that of the segment: what is above its light's sample, towards the sun, and in all.
CloudAround around_run(LayerRay r, Segment s, inout SegmentLight light, CloudRun run) {
    vec3 point = r.ray * run.t;
    float altitude = altitude_of(point),
        share = clamp((altitude - r.shell.base_m) * r.shell.per_thickness, 0.0, 1.0);
    CloudWeather w = weather_at(s, run.t, point);
#ifdef CLOUD_FINEST
    light.up = up_at(point);
    light.sun = sun_at(point, altitude, light.up);
#endif
    vec3 sun = sun_optical_depth(r.layer, point, altitude, light.up, w, sample_footprint(run.t, run.short_m));
    // Where it is not known what is behind, the clouds' own columns stand for it.
    float under = cloud_under(r.layer, share, run.column, sun.x * light.mu_s);
    return CloudAround(sun.x, r.shell.kind == CLOUD_UNIFORM ? under : mix(under, sun.y * light.mu_s, sun.z));
}

// Through one segment.
void march_segment(inout March m, inout Cursor at, LayerRay r, StepSizes sizes, Segment s) {
    SegmentLight light = segment_light(r, s);
    // What is found of a cloud depends a little on where in a step it begins. Rays side by side begin their segments
    // alike, and would all have the same of that, as a line: by the first step they are moved apart. Three times the
    // jitter: turns have all places, and with the jitter itself samples would lie at the same ones.
    float first_share = fract(3.0 * r.jitter);
    float last = s.end, air_seen = 0.0, transmittance = m.transmittance, distance_sum = m.distance_sum;
#ifndef CLOUD_FINEST
    // No sample above the tops of the segment's clouds.
    float ceiling = cloud_ceiling(r.layer, s.near_weather, s.far_weather);
    vec2 tops = shell_crossings(r.zenith_mu, r.shell.base_m + (r.shell.top_m - r.shell.base_m) * ceiling);
    last = min(tops.y, s.end);
    at.t = max(at.t, clamp(tops.x, s.begin, s.end));
#endif
    float longest = LONGEST_CLEAR_SHARE * (last - at.t);
    at.share = at.factor > 1.0 ? first_share : 1.0;
    do {
        CloudRun run = next_run(m, at, air_seen, r, sizes, s, last, longest);
        if (run.depth <= 0.0) break;
#ifdef CLOUD_FINEST
        air_seen -= 0.5 * (m.transmittance * (1.0 - exp(-run.depth))) * run.length_m;
#endif
        CloudAround around = around_run(r, s, light, run);
        add_run(m, r, s, light, run, around);
    } while (at.t < last && m.transmittance > OPAQUE);
#ifdef CLOUD_FINEST
    m.radiance += max(s.far_air.in_scatter - s.near_air.in_scatter, 0.0) * (air_seen * s.per_metre);
#else
    // Air before the mean place of what is cloud here is seen as if there were none, air behind it through all of it:
    // the shadowed air is taken off in just that way (clouds/shadowed_air.glsl).
    float opacity = transmittance - m.transmittance;
    vec3 before = opacity > 1e-4
        ? air_from_camera(r.ray * ((m.distance_sum - distance_sum) / opacity)).in_scatter
        : s.far_air.in_scatter;
    m.radiance += max(transmittance * (before - s.near_air.in_scatter)
        + m.transmittance * (s.far_air.in_scatter - before), 0.0);
#endif
}

// Through one interval of a layer, segment by segment.
void march_layer(inout March m, LayerRay r) {
    StepSizes sizes = step_sizes(r.shell.top_m - r.shell.base_m, r.from, r.to);
    int segment = 0;
    float segments = segment_count(r.shell, r.from, r.to);
    Cursor at = Cursor(r.from, sizes.clear_factor, 1.0);
    Segment s;
    s.end = r.from;
    s.far_air = air_from_camera(r.ray * r.from);
    s.far_weather = weather_along(r.ray, r.from);
    m.radiance += m.transmittance * max(s.far_air.in_scatter - m.air_in_scatter, 0.0);
    do {
        s.begin = s.end;
        s.near_air = s.far_air;
        s.near_weather = s.far_weather;
        s.end = segment_end(r.shell, r.from, r.to, segment, segments);
        s.per_metre = 1.0 / max(s.end - s.begin, 1e-3);
        s.far_air = air_from_camera(r.ray * s.end);
        s.far_weather = weather_along(r.ray, s.end);
        march_segment(m, at, r, sizes, s);
        ++segment;
    } while (float(segment) < segments && m.transmittance > OPAQUE);
    m.air_in_scatter = s.far_air.in_scatter;
    m.air_transmittance = s.far_air.transmittance;
}

LayerRay layer_ray(int layer, vec2 interval, vec3 ray, float mu, float nu, float jitter) {
    CloudViewLayer shell = cloud_view.layers[layer];
    return LayerRay(layer, shell, ray, mu, nu, interval.x, interval.y, jitter,
        shell.albedo * cloud_phase(nu, shell.asymmetry), cloud_lobes_at(shell.model, nu));
}

March march_clouds(vec3 ray, float mu, float end, float jitter) {
    March m = March(vec3(0.0), 1.0, 1.0, vec3(0.0), vec3(1.0), 0.0, 0.0);
    float nu = clamp_cos(dot(ray, frame.sun_direction));
    vec2 intervals[2 * CLOUD_VIEW_LAYERS];
    int layers[2 * CLOUD_VIEW_LAYERS];
    // Only those that there are. Software GPUs go once through all of a loop's turn, whoever has nothing to do in it,
    // and so they do in the turn in which the last ray leaves at its head: here and in what is called, rays leave at
    // the end. Water and ice have loops of their own, or each ray would go through both for each.
    int count = cloud_intervals(mu, end, intervals, layers), k = 0;
    do {
        bool on = k < count && !CLOUD_IS_CIRRUS(layers[k]);
        if (on) do {
            march_layer(m, layer_ray(layers[k], intervals[k], ray, mu, nu, jitter));
            on = ++k < count && m.transmittance > OPAQUE && !CLOUD_IS_CIRRUS(layers[k]);
        } while (on);
#ifndef CLOUD_NO_CIRRUS
        on = k < count && m.transmittance > OPAQUE && CLOUD_IS_CIRRUS(layers[k]);
        if (on) do {
            march_cirrus(m, layer_ray(layers[k], intervals[k], ray, mu, nu, jitter));
            on = ++k < count && m.transmittance > OPAQUE && CLOUD_IS_CIRRUS(layers[k]);
        } while (on);
#endif
    } while (k < count && m.transmittance > OPAQUE);
    // The picture behind brings the light of all its air: what lies before the last cloud is counted already.
    m.radiance = max(m.radiance - m.transmittance * m.air_in_scatter, 0.0);
    m.transmittance *= smoothstep(OPAQUE, 2.0 * OPAQUE, m.transmittance);
    return m;
}

// Of the clouds, in metres; UNBOUNDED where there are none.
float cloud_mean_distance(March m) {
    float opacity = 1.0 - m.transmittance;
    return opacity > 1e-4 ? m.distance_sum / opacity : UNBOUNDED;
}
