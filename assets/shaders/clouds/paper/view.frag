// The printed march through clouds and air for every pixel (Michelic 2018, section 5; Michelic et al. 2019, section 3),
// drawn over the picture with "premultiplied" blending: alpha is what clouds take of it.
//
// Defines: CLOUD_PAPER, 2018 or 2019, how clouds and air are put together. Above and below the layer the air is one
// segment; in it there are small, growing ones, each with finer steps through the clouds. Air is looked up from the
// camera, so that what a segment adds, seen from there, is a difference: T_before I_A = T_C,before (I_A to its end -
// I_A to its beginning). What a source does not say: segments begin with a quarter of the layer's thickness and grow by
// a quarter, and the six samples towards the sun share the way to the layer's top, up to 1.5 thicknesses.
#include "clouds/shells.glsl"
#include "clouds/phase.glsl"
#include "clouds/paper/density.glsl"
#if CLOUD_PAPER == 2019
#include "clouds/paper/shadow.glsl"
#include "contract/sky.glsl"
#endif
#include "common/planet_shadow.glsl"
#include "contract/air.glsl"

layout(binding = 0) uniform sampler2D u_depth;
layout(location = 0) uniform float u_small_step_m;
layout(location = 1) uniform float u_large_step_m;
#if CLOUD_PAPER == 2019
layout(location = 2) uniform int u_shafts;
#endif
layout(location = 0) out vec4 o_color;

const int PAPER_SUN_SAMPLES = 6, PAPER_MOST_SEGMENTS = 96, PAPER_MOST_TURNS = 16384;
const float PAPER_FIRST = 0.25, PAPER_GROWTH = 1.25, PAPER_SUN_WAY = 1.5;
const int PAPER_SHAFT_SLICES = 12;
const float PAPER_OPAQUE = 0.004;    // no more than a step of an 8-bit picture is left
const float PAPER_UNBOUNDED = 1e9;

struct PaperMarch {
    vec3 radiance;         // towards the camera
    float transmittance;   // of the clouds so far
    Air air;               // from the camera to the last segment's end
    float t;               // m: of the next sample
};

// Of a segment, each over all its steps: of the clouds, of a scattering factor of 1 and a sun of irradiance 1.
struct PaperClouds {
    float transmittance;
    float light, late_light;   // (16); the latter: each step's times its share of the segment
    float visible_m;           // metres, each times the transmittance before it
};

// A turn of the loop is one sample of density, on the ray or towards the sun. mu: cosine of the sun to the zenith.
// last: the end of the way through the layer, where the last step is cut off.
PaperClouds paper_clouds(inout PaperMarch m, CloudViewLayer shell, vec3 ray, float mu, float begin, float end,
    bool last) {
    PaperClouds c = PaperClouds(1.0, 0.0, 0.0, 0.0);
    vec3 sun = frame.sun_direction, place = vec3(0.0);
    float level = paper_level(begin), per_metre = 1.0 / max(end - begin, 1e-3);
    float held = 0.0, sun_sum = 0.0, sun_step = 0.0;
    float until = last ? end + 0.5 * u_small_step_m : end;
    int sample_number = -1;   // -1: on the ray, else of the samples towards the sun
    for (int turn = 0; turn < PAPER_MOST_TURNS && m.t < until && m.transmittance * c.transmittance > PAPER_OPAQUE;
         ++turn) {
        bool aside = sample_number >= 0;
        vec3 point = aside ? place + sun * (sun_step * (float(sample_number) + 0.5)) : ray * m.t;
        float altitude = altitude_of(point);
        float density = paper_density(point + frame.camera_offset_m, altitude, level);
        bool meets = !aside && density > 0.0, done = sample_number == PAPER_SUN_SAMPLES - 1;
        float part = (m.t - begin) * per_metre, step_m = density < 0.0 ? u_large_step_m : u_small_step_m;
        sun_sum += aside ? max(density, 0.0) : 0.0;
        // Equations 15 and 16, once the sun's light at this place is known.
        float depth = done ? shell.extinction_per_m * min(u_small_step_m, until - m.t) * held : 0.0;
        c.transmittance *= exp(-depth);
        float light = depth * exp(-shell.extinction_per_m * sun_step * sun_sum) * c.transmittance;
        c.light += light;
        c.late_light += light * part;
        float on = done ? u_small_step_m : aside || meets ? 0.0 : step_m;
        c.visible_m += c.transmittance * clamp(end - m.t, 0.0, on);
        m.t += on;
        held = meets ? density : held;
        place = meets ? point : place;
        sun_step = meets ? min(paper_rise(altitude, mu, shell.top_m), PAPER_SUN_WAY * (shell.top_m - shell.base_m))
            / float(PAPER_SUN_SAMPLES) : sun_step;
        sun_sum = meets ? 0.0 : sun_sum;
        sample_number = meets ? 0 : done ? -1 : aside ? sample_number + 1 : -1;
    }
    return c;
}

void paper_segment(inout PaperMarch m, CloudViewLayer shell, vec3 ray, float begin, float end, float phase,
    bool last) {
    vec3 middle = ray * (0.5 * (begin + end));
    float mu = dot(up_at(middle), frame.sun_direction);
    float visibility = sun_visibility_of_sphere(altitude_of(middle), mu, frame.sun_radius_rad);
    Air there = air_from_camera(ray * end);
    PaperClouds c = paper_clouds(m, shell, ray, mu, begin, end, last);
    vec3 scattered = shell.albedo * phase * visibility * frame.sun_irradiance;
    vec3 air = max(there.in_scatter - m.air.in_scatter, 0.0);
#if CLOUD_PAPER == 2018
    // (20)
    m.radiance += m.transmittance * (air * c.transmittance + m.air.transmittance * scattered * c.light);
#else
    // The air's light comes evenly along the segment and its transmittance runs linearly: both at each step of the
    // cloud.
    float per_metre = 1.0 / max(end - begin, 1e-3);
    m.radiance += m.transmittance * (air * clamp(c.visible_m * per_metre, c.transmittance, 1.0)
        + scattered * (m.air.transmittance * (c.light - c.late_light) + there.transmittance * c.late_light));
#endif
    // (19)
    m.transmittance *= c.transmittance;
    m.air = there;
}

// One interval of the ray in the layer.
void paper_interval(inout PaperMarch m, vec3 ray, float from, float to, float phase) {
    CloudViewLayer shell = cloud_view.layers[0];
    float length_m = PAPER_FIRST * (shell.top_m - shell.base_m), begin = from;
    m.t = from + 0.5 * u_small_step_m;
    Air before = air_from_camera(ray * from);
    m.radiance += m.transmittance * max(before.in_scatter - m.air.in_scatter, 0.0);
    m.air = before;
    for (int segment = 0; segment < PAPER_MOST_SEGMENTS && begin < to && m.transmittance > PAPER_OPAQUE; ++segment) {
        float end = segment == PAPER_MOST_SEGMENTS - 1 ? to : min(begin + length_m, to);
        paper_segment(m, shell, ray, begin, end, phase, end == to);
        begin = end;
        length_m *= PAPER_GROWTH;
    }
}

#if CLOUD_PAPER == 2019
// The air below the clouds, in slices that grow away from the camera: each slice's light comes as far as the clouds let
// the sun through to its middle, by one sample of density as for the ground.
void paper_shafts(inout PaperMarch m, vec3 ray, float from, float to) {
    float begin = from, growth = 1.0 / float(PAPER_SHAFT_SLICES * PAPER_SHAFT_SLICES);
    Air before = air_from_camera(ray * from);
    m.radiance += m.transmittance * max(before.in_scatter - m.air.in_scatter, 0.0);
    for (int k = 1; k <= PAPER_SHAFT_SLICES; ++k) {
        float end = mix(from, to, float(k * k) * growth);
        Air there = air_from_camera(ray * end);
        float lit = cloud_shadow(ray * (0.5 * (begin + end)));
        m.radiance += m.transmittance * lit * max(there.in_scatter - before.in_scatter, 0.0);
        before = there;
        begin = end;
    }
    m.air = before;
}
#endif

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 ray = view_ray(ndc_of_pixel(vec2(pixel) + 0.5));
    float ray_length = length(ray), depth = texelFetch(u_depth, pixel, 0).r;
    float end = depth > 0.0 ? forward_distance(depth) * ray_length : PAPER_UNBOUNDED;
    ray /= ray_length;
    float mu = clamp_cos(dot(ray, frame.camera_zenith));
    vec3 aside = cross(ray, frame.camera_zenith);
    shell_sine2 = dot(aside, aside);
    // The planet itself, where nothing was drawn on it.
    vec2 floor_ = shell_crossings(mu, min(planet.lowest_drawn_m, frame.camera_altitude_m));
    if (depth <= 0.0 && mu < 0.0 && floor_.x < floor_.y) end = min(end, floor_.x);
    vec4 intervals = shell_intervals(mu, cloud_view.layers[0].base_m, cloud_view.layers[0].top_m, end);
    float phase = cloud_phase(clamp_cos(dot(ray, frame.sun_direction)), cloud_view.layers[0].asymmetry);
    PaperMarch m = PaperMarch(vec3(0.0), 1.0, Air(vec3(1.0), vec3(0.0)), 0.0);
    for (int k = 0; k < 2; ++k) {
        if (intervals[2 * k + 1] - intervals[2 * k] > 1e-3 && m.transmittance > PAPER_OPAQUE)
            paper_interval(m, ray, intervals[2 * k], intervals[2 * k + 1], phase);
#if CLOUD_PAPER == 2019
        if (k == 0 && u_shafts != 0 && intervals.z - intervals.y > 1e-3 && m.transmittance > PAPER_OPAQUE)
            paper_shafts(m, ray, intervals.y, intervals.z);
#endif
    }
    // The picture behind brings the light of all its air: what lies before the last cloud is counted already.
    // Less than nothing is added where it has light that does not come through the clouds.
    vec3 counted = m.air.in_scatter;
#if CLOUD_PAPER == 2019
    // By rounding the tables may give less for the whole sky than up to a point, and under clouds nothing makes up for
    // that.
    if (depth <= 0.0) counted = min(counted, (1.0 - 1e-6) * sky(ray));
#endif
    float through = m.transmittance < PAPER_OPAQUE ? 0.0 : m.transmittance;
    m.radiance -= through * counted;
    o_color = vec4(m.radiance * frame.hdr_per_radiance, 1.0 - through);
}
