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
#include "common/planet_shadow.glsl"
#include "contract/air.glsl"

layout(binding = 0) uniform sampler2D u_depth;
layout(location = 0) uniform vec2 u_steps;   // metres: small, large
layout(location = 0) out vec4 o_color;

const int PAPER_SUN_SAMPLES = 6, PAPER_MOST_SEGMENTS = 96, PAPER_MOST_TURNS = 16384;
const float PAPER_FIRST = 0.25, PAPER_GROWTH = 1.25, PAPER_SUN_WAY = 1.5;
const float PAPER_OPAQUE = 0.004;    // no more than a step of an 8-bit picture is left
const float PAPER_NOT_ALL = 1e9;

struct PaperMarch {
    vec3 light;   // towards the camera
    float open;   // transmittance of the clouds so far
    Air here;     // from the camera to the last segment's end
};

// One way through the layer. A turn of the inner loop is one sample of density, on the ray or on the way to the sun.
void paper_way(inout PaperMarch m, vec3 ray, float from, float to, float phase) {
    CloudViewLayer shell = cloud_view.layers[0];
    vec3 sun = frame.sun_direction.xyz;
    float thickness = shell.top_m - shell.base_m, length_m = PAPER_FIRST * thickness, begin = from,
        t = from + 0.5 * u_steps.x;
    Air before = air_from_camera(ray * from);
    m.light += m.open * max(before.in_scatter - m.here.in_scatter, 0.0);
    m.here = before;
    for (int segment = 0; segment < PAPER_MOST_SEGMENTS && begin < to && m.open > PAPER_OPAQUE; ++segment) {
        float past = segment == PAPER_MOST_SEGMENTS - 1 ? to : min(begin + length_m, to);
        vec3 middle = ray * (0.5 * (begin + past));
        float mu = dot(up_at(middle), sun);
        float seen = sun_visibility_of_sphere(altitude_of(middle), mu, frame.sun_direction.w);
        Air there = air_from_camera(ray * past);
        float cloud = 1.0, alone = 0.0, late = 0.0, lit = 0.0, per_metre = 1.0 / max(past - begin, 1e-3);
        float held = 0.0, sun_sum = 0.0, sun_step = 0.0;
        vec3 place = vec3(0.0);
        int sample_number = -1;   // -1: on the ray, else of the samples towards the sun
        for (int turn = 0; turn < PAPER_MOST_TURNS && t < past && m.open * cloud > PAPER_OPAQUE; ++turn) {
            bool aside = sample_number >= 0;
            vec3 point = aside ? place + sun * (sun_step * (float(sample_number) + 0.5)) : ray * t;
            float altitude = altitude_of(point);
            float density = paper_density(point + frame.camera_offset.xyz, altitude);
            bool meets = !aside && density > 0.0, done = sample_number == PAPER_SUN_SAMPLES - 1;
            float part = (t - begin) * per_metre, step_m = density < 0.0 ? u_steps.y : u_steps.x;
            sun_sum += aside ? max(density, 0.0) : 0.0;
            // Equations 15 and 16, once the sun's light at this place is known.
            float taken = done ? shell.extinction_per_m * u_steps.x * held : 0.0;
            cloud *= exp(-taken);
            float light = taken * exp(-shell.extinction_per_m * sun_step * sun_sum) * cloud;
            alone += light;
            late += light * part;
            float on = done ? u_steps.x : aside || meets ? 0.0 : step_m;
            lit += cloud * min(on, past - t);
            t += on;
            held = meets ? density : held;
            place = meets ? point : place;
            sun_step = meets ? min(paper_rise(altitude, mu, shell.top_m), PAPER_SUN_WAY * thickness)
                / float(PAPER_SUN_SAMPLES) : sun_step;
            sun_sum = meets ? 0.0 : sun_sum;
            sample_number = meets ? 0 : done ? -1 : aside ? sample_number + 1 : -1;
        }
        vec3 scattered = shell.albedo * phase * seen * frame.sun_irradiance.rgb;
        vec3 air = max(there.in_scatter - m.here.in_scatter, 0.0);
#if CLOUD_PAPER == 2018
        // (20)
        m.light += m.open * (air * cloud + m.here.transmittance * scattered * alone);
#else
        // The air's light comes evenly along the segment and its transmittance runs linearly: both at each step of the
        // cloud.
        m.light += m.open * (air * clamp(lit * per_metre, cloud, 1.0)
            + scattered * (m.here.transmittance * (alone - late) + there.transmittance * late));
#endif
        // (19)
        m.open *= cloud;
        m.here = there;
        begin = past;
        length_m *= PAPER_GROWTH;
    }
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 ray = view_ray(ndc_of_pixel(vec2(pixel) + 0.5));
    float stretch = length(ray), depth = texelFetch(u_depth, pixel, 0).r;
    float end = depth > 0.0 ? forward_distance(depth) * stretch : PAPER_NOT_ALL;
    ray /= stretch;
    float mu = clamp_cos(dot(ray, frame.camera_zenith.xyz));
    vec3 aside = cross(ray, frame.camera_zenith.xyz);
    shell_sine2 = dot(aside, aside);
    // The planet itself, where nothing was drawn on it.
    vec2 floor_ = shell_crossings(mu, min(planet.radii.w, frame.camera_zenith.w));
    if (depth <= 0.0 && mu < 0.0 && floor_.x < floor_.y && frame.camera_zenith.w > planet.radii.w)
        end = min(end, floor_.x);
    vec4 ways = shell_ways(mu, cloud_view.layers[0].base_m, cloud_view.layers[0].top_m, end);
    float phase = cloud_phase(clamp_cos(dot(ray, frame.sun_direction.xyz)), cloud_view.layers[0].asymmetry);
    PaperMarch m = PaperMarch(vec3(0.0), 1.0, Air(vec3(1.0), vec3(0.0)));
    for (int k = 0; k < 2; ++k) {
        if (ways[2 * k + 1] - ways[2 * k] > 1e-3 && m.open > PAPER_OPAQUE)
            paper_way(m, ray, ways[2 * k], ways[2 * k + 1], phase);
    }
    // The picture behind brings the light of all its air: what lies before the last cloud is counted already.
    m.light = max(m.light - m.open * m.here.in_scatter, 0.0);
    o_color = vec4(m.light * frame.scale.x, m.open < PAPER_OPAQUE ? 1.0 : 1.0 - m.open);
}
