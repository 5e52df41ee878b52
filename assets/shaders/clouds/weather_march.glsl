// The march along one ray through the layers of cloud that follow the weather, with the air in front and between.
//
//   March march_clouds(vec3 ray, float mu, float end, float shift)
//
// ray: unit, from the camera; mu: its cosine to the zenith; end: how far it goes; shift: 0..1, of the steps. Whoever
// includes this sets pixel_rad and cloud_dither first. Without air in front: out = open * picture (its own air
// included) + light.
#include "common/camera.glsl"
#include "clouds/ways.glsl"
#include "clouds/light.glsl"
#include "clouds/scattered.glsl"
#include "clouds/sun_depth.glsl"
#include "clouds/sun_march.glsl"
#include "clouds/through.glsl"
#include "contract/air.glsl"
#include "contract/sky.glsl"

// Of the ground around, whose light clouds scatter as well.
#ifndef CLOUD_GROUND
#define CLOUD_GROUND 0.12
#endif

const int CLEAR_STRETCH = 5;   // steps through the clear until rays beside one another wait for those in cloud
const float OPAQUE = CLOUD_DEEPEST > 40.0 ? 1e-5 : 0.004;   // the latter is no more than a step of an 8-bit picture
const float SUN_LEVEL = 0.04;   // of a sun below the horizon maps know the way from the ray's lowest point on only
const float MOST_STRETCH = 0.25;  // of a segment, in a step through the clear
const float MOST_SLOPE = 50.0;  // of the optical depth towards the sun over that along the ray
// steps around the eye, where a layer's thickness has NEAREST_STEPS or more
const float NEAREST_M = 4.0, NEAREST_GROWTH = 0.02;
const float NEAREST_STEPS = 96.0;

// Finest steps: the weather and the sunlight of each place, and no wisp is stepped over.
#ifdef CLOUD_FINEST
const float LONG_STEPS = 1.0, LONGER = 0.0, BEHIND = 0.0;
const float LOOK_STEPS = 0.0;
const float THIN_STEPS = 0.16;   // through ice, of the short ones
const float SKIN = 1e-4;          // first and last step, of a short one
#define WEATHER_AT(here, there, part, point, wide) cloud_weather(up_at(point), wide)
#else
const float LONG_STEPS = 3.0;   // through the clear
const float LONGER = 1.0;        // and these still, per unit of noise that is missing for a cloud
const float BEHIND = 1.0;        // steps behind cloud against those before it, less one: what is there is hardly seen
const float LOOK_STEPS = 0.5;    // fine ones that share one look at the light, beyond two
const float THIN_STEPS = 0.04;   // through ice, of the short ones
#define WEATHER_AT(here, there, part, point, wide) cloud_weather_between(here, there, part)
#endif

struct March {
    vec3 light;        // towards the camera
    float open;        // transmittance of the clouds so far
    float wide;        // the same for light that was scattered before: what goes straight on is not lost to it
    vec3 air_behind;   // light of the air between camera and the last segment's end
    vec3 air_past;     // transmittance of that air
    float sum;         // of distance times what was taken, to find the clouds' mean distance
    float steps;       // places that were looked at, those towards the sun not counted
};

vec3 sun_at(vec3 point, float altitude, vec3 up) {
    float h = max(altitude, 0.0) / planet.radii.x, sin_h = 1.0 / (1.0 + h), cos_h = -sqrt(h * (2.0 + h)) * sin_h;
    float soft = frame.sun_direction.w * sin_h;
    float seen = smoothstep(-soft, soft, dot(up, frame.sun_direction.xyz) - cos_h);
    return frame.sun_irradiance.rgb * seen * air_to_space(point, frame.sun_direction.xyz);
}

// Optical depth towards the sun: of the layer itself in a few steps as far as maps of the shadow are too coarse for,
// then of all clouds from the maps. Without CLOUD_MAPPED (many steps, which are as good as the maps) the layer has them
// all the way, and others, which are farther, a quarter as many.
float depth_to_sun(int layer, vec3 point, float altitude, vec3 up, CloudWeather w, float footprint) {
    CloudViewLayer shell = cloud_view.layers[layer];
    float mu = dot(up, frame.sun_direction.xyz), thickness = shell.top_m - shell.base_m;
    // To the top, over a curved layer: a level ray leaves it, too.
    float rise = max(shell.top_m - altitude, 0.0), r = planet.radii.x + altitude;
    float b = r * mu, root = sqrt(max(b * b + rise * (2.0 * r + rise), 0.0));
    float way = b >= 0.0 ? rise * (2.0 * r + rise) / max(root + b, 1.0) : root - b;
#ifdef CLOUD_MAPPED
    way = min(way, 6.0 * thickness);
    CloudSunPlace ray = cloud_sun_ray(point, altitude, mu, footprint);
    float near = mix(way, min(way, max(0.08 * thickness, 1.5 * cloud_map_texel(ray.level))),
        smoothstep(0.0, SUN_LEVEL, mu));
#else
    way = min(way, 1e9);
    float near = way;
#endif
#ifdef CLOUD_FINEST
    float most = u_march.w;
#else
    // Ice is thin; and what is averaged over the way there needs no steps of its own.
    float most = CLOUD_IS_ICE(layer) ? 1.0 : u_march.w * min(2.0 * way / footprint, 1.0);
#endif
    // Short steps first: what is near casts the sharpest shadows. So many of them lie in the part that is marched.
    int steps = max(int(ceil(most * sqrt(near / max(way, 1e-3)))), 1), i = 0;
    float sum = 0.0, from = 0.0, per_step = 1.0 / float(steps);
    do {
        float part = float(++i) * per_step, to = near * part * part, t = 0.5 * (from + to);
        vec3 at = point + frame.sun_direction.xyz * t;
        float height = altitude + t * mu + 0.5 * t * t * (1.0 - mu * mu) / r;
        float share = (height - shell.base_m) * shell.per_thickness;
        sum += (to - from) * cloud_density(layer, at + frame.camera_offset.xyz, clamp(share, 0.0, 1.0), w,
            max(footprint, 0.35 * (to - from)), 0) * step(share, 1.0);
        from = to;
    } while (i < steps);
    sum *= shell.extinction_per_m;
#ifdef CLOUD_MAPPED
    float past = altitude + near * mu + 0.5 * near * near * (1.0 - mu * mu) / r;
    return sum + cloud_sunlight_on(ray, past, mu + near / r).y;
#else
    return sum + cloud_depth_marched(layer, point, altitude, mu, 0.25 * u_march.w, footprint);
#endif
}

// Light of the sky above and of the ground below that droplets scatter towards the camera, in Eddington's
// approximation: what comes from behind the place keeps its direction most. mu: cosine of the ray to the zenith.
vec3 cloud_from_around(vec3 sky, vec3 ground, float up, float down, float mu, float g) {
    float turned = 1.0 - g, whole = turned * (up + down) + 4.0 / 3.0;
    return (sky * (turned * down + 2.0 / 3.0 * (1.0 + g * mu)) + ground * (turned * up + 2.0 / 3.0 * (1.0 - g * mu)))
        / whole;
}

// Where in a step of optical depth `depth` chance (0..1) finds what is seen of it.
float seen_share(float depth, float chance) {
    return depth < 0.02 ? chance : -log(1.0 - chance * (1.0 - exp(-depth))) / depth;
}

// One way through one layer. Long steps through the clear; where there is cloud, back to the last clear place and on in
// short steps, which the cloud's own extinction and a pixel's width at that distance measure out. zenith: cosine at the
// camera.
void march_way(inout March m, int layer, vec3 ray, float zenith, float from, float to, float nu, float shift) {
    CloudViewLayer shell = cloud_view.layers[layer];
    float thickness = shell.top_m - shell.base_m, way = to - from;
    bool thin = CLOUD_IS_ICE(layer);
    float least = thickness / u_march.x, grow = max(u_march.y, way / (600.0 * max(to + ray_walked, 1.0)));
    float coarser = max(NEAREST_STEPS / u_march.x, 1.0);
    float longer = thin ? 1.0 : LONG_STEPS, farther = thin ? 0.0 : LONGER, most = max(way / (0.3 * u_march.x), least);
    // Of the way and of a pixel's width: steps where clouds are averaged. Who asks for more steps than pictures need
    // gets them there, too.
    float widest = 1.0 / max(8.0, u_march.x * u_march.x / 2000.0),
        narrowest = 0.3 * min(1.0, 2.0 * WAY_STEPS / u_march.x);
    if (thin) least = most = way / ceil(THIN_STEPS * u_march.x * log2(2.0 * way / thickness + 2.0));
    int segments = way_segments(shell, thin, from, to);
    float t = from, ease = longer, begin = from;
    Air here = air_from_camera(ray * from);
    CloudWeather weather_here = weather_along(ray, from);
    m.light += m.open * max(here.in_scatter - m.air_behind, 0.0);
    int model = shell.model;
    CloudLobes lobes = cloud_lobes_at(model, nu);
    float once = shell.albedo * cloud_phase(nu, shell.asymmetry), passes = 1.0 - lobes.peak;
    // Fine steps that share one look at the light: as long as they are thin together.
    float spare = 48.0 / u_march.x, fine = way_fineness(), looks = 2.0 + LOOK_STEPS * fine, behind_all = BEHIND * fine;
    int segment = 0;
    do {
        float past = way_end(shell, from, to, segment, segments);
        vec3 middle = ray * (0.5 * (begin + past));
        vec3 up_middle = up_at(middle);
        vec3 sun = sun_at(middle, altitude_of(middle), up_middle);
        float mu_s = dot(up_middle, frame.sun_direction.xyz), level_sun = cloud_slab_sun(model, mu_s);
        float mu = clamp_cos(dot(ray, up_middle));
        vec3 sky = sky_irradiance(middle, up_middle) / PF_PI;
        Air there = air_from_camera(ray * past);
        // Weather changes over tens of kilometres: in between it is taken as even.
        CloudWeather weather_there = weather_along(ray, past),
            weather_middle = cloud_weather_between(weather_here, weather_there, 0.5);
        float sides = cloud_sides(layer, weather_middle), closed = cloud_closed(layer, weather_middle);
        float slab_sun = cloud_facing(level_sun, sides);
        CloudHarmonics harmonics = cloud_harmonics(mu, mu_s + slab_sun - level_sun, nu);
        // The ground under a closed sky has what comes through it; under clouds with gaps, nearly all there is.
        vec4 through = cloud_through(cloud_column(layer, weather_middle, 1.0) / level_sun, level_sun, shell.asymmetry);
        through = mix(vec4(1.0, 0.0, 1.0, 0.0), through, closed);
        vec3 ground = CLOUD_GROUND / PF_PI * (sun * (max(mu_s, 0.0) * (through.x + through.y)))
            + CLOUD_GROUND * through.z * sky;
        float per_metre = 1.0 / max(past - begin, 1e-3);
        // Nothing is looked for above the tops of the segment's clouds.
        float last = past;
#ifndef CLOUD_FINEST
        float ceiling = cloud_ceiling(layer, weather_here, weather_there);
        vec2 tops = shell_crossings(zenith, shell.base_m + thickness * ceiling);
        last = min(tops.y, past);
        t = max(t, thin ? begin : clamp(tops.x, begin, past));
#endif
        float stretch_m = MOST_STRETCH * (last - t);
#ifdef CLOUD_FINEST
        float seen = 0.0;
#else
        float open = m.open, sum = m.sum;
#endif
        do {
            // Through the clear and into cloud, apart from its light, so that rays in the clear don't pay for that.
            float depth = 0.0, at = 0.0, inside = 0.0, weight = 0.0, unit = 0.0, length_m = 0.0;
            float behind = 1.0 + behind_all * (1.0 - m.open);
            int steps = 0;
            bool on_in;
            do {
                float step_m, share, footprint;
                CloudNoise noise;
                float gap;
                int stretch = 0;
                do {
                    float away = t + ray_walked;
                    unit = min(max(min(least, thin ? least : coarser * (NEAREST_M + NEAREST_GROWTH * away)),
                        away * grow) * behind, most);
                    // Clouds that a pixel is too wide to show have smooth means.
                    unit = min(max(unit, narrowest * away * pixel_rad), max(way * widest, unit));
#ifdef CLOUD_FINEST
                    // A low sun lights but a skin of an even layer: steps grow from where the ray enters it, and shrink
                    // to where it leaves.
                    unit = min(unit, SKIN * least + 1e-6 * t + 0.15 * min(t - from, to - t));
#endif
                    step_m = clamp(last - t + 1e-3, 0.0, min(unit * ease, max(unit, stretch_m)));
                    float here_m = t + shift * step_m;
                    vec3 point = ray * here_m;
                    share = clamp((altitude_of(point) - shell.base_m) * shell.per_thickness, 0.0, 1.0);
                    CloudWeather w = WEATHER_AT(weather_here, weather_there, (here_m - begin) * per_metre, point,
                        (here_m + ray_walked) * pixel_rad);
                    m.steps += 1.0;
                    footprint = max((here_m + ray_walked) * pixel_rad, 0.2 * unit);
                    noise = cloud_noise(layer, point + frame.camera_offset.xyz, share, w, footprint);
                    gap = cloud_gap(layer, noise, footprint);
                    // Surely clear: on, without a look at the rims.
                    t += gap > 0.0 ? step_m : 0.0;
                    ease = gap > 0.0 ? min(ease * 1.4, longer) * (1.0 + farther * gap) : ease;
#ifdef CLOUD_FINEST
                    seen += gap > 0.0 ? m.open * step_m : 0.0;
#endif
                } while (gap > 0.0 && depth <= 0.0 && t < last && ++stretch < CLEAR_STRETCH);
                bool near = gap <= 0.0;
                float density = near ? cloud_rimmed(layer, noise, share, footprint, 2) : 0.0;
                // In cloud: the same stretch again, in short steps; or on.
                bool found = density > 1e-4, again = found && ease > 1.0 && !thin;
                float on = again || !near ? 0.0 : step_m, taken = found ? shell.extinction_per_m * density * on : 0.0;
#ifdef CLOUD_FINEST
                seen += m.open * on;
#endif
                // Light is looked up where a step is seen: the thicker it is, the nearer to its begin.
                float shown = exp(-depth) * taken * one_minus_exp_over(taken), within = seen_share(taken, shift);
                at += shown * (t + on * within);
                inside += shown * (depth + taken * within);
                weight += shown;
                depth += taken;
                t += on;
                ease = found ? 1.0 : near ? min(ease * 1.4, longer) : ease;
                steps += on > 0.0 && found ? 1 : 0;
                length_m += found ? on : 0.0;
                on_in = depth <= spare * behind && float(steps) < looks * behind && (found || depth <= 0.0);
            } while (t < last && on_in);
            if (depth <= 0.0) break;
            at /= weight;
            inside /= weight;
            vec3 point = ray * at;
            float altitude = altitude_of(point),
                share = clamp((altitude - shell.base_m) * shell.per_thickness, 0.0, 1.0);
            float part = (at - begin) * per_metre, footprint = max((at + ray_walked) * pixel_rad, 0.2 * unit);
            CloudWeather w = WEATHER_AT(weather_here, weather_there, part, point, (at + ray_walked) * pixel_rad);
#ifdef CLOUD_FINEST
            up_middle = up_at(point);
            sun = sun_at(point, altitude, up_middle);
#endif
            float to_sun = depth_to_sun(layer, point, altitude, up_middle, w, footprint), up = to_sun * slab_sun;
            float mean_density = depth / (length_m * shell.extinction_per_m),
                down = cloud_under(layer, share, cloud_column(layer, w, mean_density), up);
            float taken = m.open * (1.0 - exp(-depth)), left = exp(-passes * depth);
            // Across an even layer the way to the sun gets longer or shorter evenly; of clouds with sides nobody knows.
            float longer_way = (1.0 - sides) * clamp(-mu / slab_sun, -MOST_SLOPE, MOST_SLOPE);
            float first = max(to_sun - longer_way * inside, 0.0),
                last = depth + max(to_sun + longer_way * (depth - inside), 0.0);
            // Mean over the step of what is left of it on its way in and out, as a depth.
            float dimmed = min(first, last) - log(one_minus_exp_over(abs(last - first)));
            float lit = m.open * depth * exp(-dimmed);
            vec3 direct = sun * (once * lit * cloud_lobes_sum(lobes, dimmed - log(m.open)));
            vec3 diffuse = sun * cloud_slab_light(model, up, down, slab_sun, harmonics)
                + (shell.albedo - lobes.peak) * cloud_from_around(sky, ground, up, down, mu, shell.asymmetry);
#ifdef CLOUD_ONCE
            // Light that was scattered once and no more, for who asks for it.
            direct = sun * (once * lit);
            diffuse = vec3(0.0);
#endif
            m.open -= taken;
            // What is left out where nothing behind is seen any more is as bright as the last of it.
            left = m.open > OPAQUE ? left : 0.0;
            m.light += mix(here.transmittance, there.transmittance, part)
                * (direct + m.wide * (1.0 - left) / passes * diffuse);
            m.wide *= left;
            m.sum += taken * at;
#ifdef CLOUD_FINEST
            seen -= 0.5 * taken * length_m;
#endif
        } while (t < last && m.open > OPAQUE);
#ifdef CLOUD_FINEST
        m.light += max(there.in_scatter - here.in_scatter, 0.0) * (seen * per_metre);
#else
        // Air before the mean place of what is cloud here is seen as if there were none, air behind it through all of
        // it: the shadowed air is taken off in just that way (clouds/shadowed_air.glsl).
        float hidden = open - m.open;
        vec3 before = hidden > 1e-4 ? air_from_camera(ray * ((m.sum - sum) / hidden)).in_scatter : there.in_scatter;
        m.light += max(open * (before - here.in_scatter) + m.open * (there.in_scatter - before), 0.0);
#endif
        here = there;
        weather_here = weather_there;
        begin = past;
        ++segment;
    } while (segment < segments && m.open > OPAQUE);
    m.air_behind = here.in_scatter;
    m.air_past = here.transmittance;
}

March march_clouds(vec3 ray, float mu, float end, float shift) {
    March m = March(vec3(0.0), 1.0, 1.0, vec3(0.0), vec3(1.0), 0.0, 0.0);
    float nu = clamp_cos(dot(ray, frame.sun_direction.xyz));
    vec2 spans[2 * CLOUD_VIEW_LAYERS];
    int layers[2 * CLOUD_VIEW_LAYERS];
    // Only those that there are. Software GPUs go once through all of a loop's turn, whoever has nothing to do in it,
    // and so they do in the turn in which the last ray leaves at its head: here and in what is called, rays leave at
    // the end.
    int count = cloud_ways(mu, end, spans, layers), k = 0;
    do {
        if (k < count) march_way(m, layers[k], ray, mu, spans[k].x, spans[k].y, nu, shift);
        ++k;
    } while (k < count && m.open > OPAQUE);
    // The picture behind brings the light of all its air: what lies before the last cloud is counted already.
    m.light = max(m.light - m.open * m.air_behind, 0.0);
    m.open = m.open < OPAQUE ? 0.0 : m.open;
    return m;
}
