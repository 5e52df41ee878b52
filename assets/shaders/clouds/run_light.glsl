// A run of steps through cloud, as one: the light that it sends to the camera, and what it takes of what is behind.
//
//   SegmentLight segment_light(LayerRay r, Segment s)
//   void add_run(inout March m, LayerRay r, Segment s, SegmentLight light, CloudRun run, CloudAround around)
#include "common/constants.glsl"
#include "common/camera.glsl"
#include "clouds/intervals.glsl"
#include "clouds/light.glsl"
#include "clouds/scattered.glsl"
#include "clouds/slab_transmittance.glsl"
#include "contract/air.glsl"
#include "contract/sky.glsl"

// Of the ground around, whose light clouds scatter as well.
#ifndef CLOUD_GROUND
#define CLOUD_GROUND 0.12
#endif

// transmittance behind which nothing is seen: the latter is no more than a step of an 8-bit picture
const float OPAQUE = CLOUD_DEEPEST > 40.0 ? 1e-5 : 0.004;
const float NEARLY_OPAQUE = 8.0 * OPAQUE;
const float MOST_SLOPE = 50.0;      // of the optical depth towards the sun over that along the ray
const float LEAST_DENSITY = 1e-4;   // that counts as cloud

struct March {
    vec3 radiance;                 // in-scattered towards the camera, for the camera's sun
    float transmittance;           // of the clouds so far
    float diffuse_transmittance;   // of light that was scattered before: what goes straight on is not lost to it
    vec3 air_in_scatter;           // of the air between camera and the last segment's end
    vec3 air_transmittance;        // of that air
    float distance_sum;            // m: of distances times opacity, to find the clouds' mean distance
    float samples;                 // of density, those towards the sun not counted
};

// One interval of a ray in a layer, and what doesn't change in it.
struct LayerRay {
    int layer;
    CloudViewLayer shell;
    vec3 ray;
    float zenith_mu;         // cosine to the zenith, at the camera
    float nu;                // to the sun
    float from, to, jitter;
    float single;            // albedo times phase function
    CloudLobes lobes;
};

// A segment, at whose ends weather and air are known; metres along the ray.
struct Segment {
    float begin, end, per_metre;   // the latter: 1 / length
    CloudWeather near_weather, far_weather;
    Air near_air, far_air;
};

// What lights it, at its middle.
struct SegmentLight {
    vec3 up, sun;       // zenith; the sun's irradiance through the air
    vec3 sky, ground;   // mean radiance from above and from below
    float mu, mu_s;     // cosines to the zenith of the ray, and of the sun for the slab that stands for the clouds
    float sides;        // 0: a sheet from edge to edge, 1: towers
    CloudHarmonics harmonics;
};

// Steps through cloud that share one sample of their light.
struct CloudRun {
    float depth;             // optical
    float t, depth_before;   // where it is seen on the mean: in metres, and optical depth of the run before that
    float length_m, short_m; // in cloud; of its last short step
    float column;            // vertical optical depth of the clouds there, on the mean
};

// Optical depth around a run of steps: towards the sun, and below it.
struct CloudAround {
    float sun_depth, under;
};

// The sun's irradiance on clouds, by how much of its disc stands above the sphere and through the air above.
vec3 sun_at(vec3 point, float altitude, vec3 up) {
    float h = max(altitude, 0.0) / planet.radius_m, sin_h = 1.0 / (1.0 + h), cos_h = -sqrt(h * (2.0 + h)) * sin_h;
    float soft = frame.sun_radius_rad * sin_h;
    float visible = smoothstep(-soft, soft, dot(up, frame.sun_direction) - cos_h);
    return frame.sun_irradiance * visible * air_to_space(point, frame.sun_direction);
}

// Light of the sky above and of the ground below that droplets scatter towards the camera, in Eddington's
// approximation: what comes from behind the place keeps its direction most. mu: cosine of the ray to the zenith.
vec3 cloud_from_around(vec3 sky, vec3 ground, float up, float down, float mu, float g) {
    float turned = 1.0 - g, whole = turned * (up + down) + 4.0 / 3.0;
    return (sky * (turned * down + 2.0 / 3.0 * (1.0 + g * mu)) + ground * (turned * up + 2.0 / 3.0 * (1.0 - g * mu)))
        / whole;
}

SegmentLight segment_light(LayerRay r, Segment s) {
    vec3 middle = r.ray * (0.5 * (s.begin + s.end)), up = up_at(middle);
    vec3 sun = sun_at(middle, altitude_of(middle), up);
    float mu_s = dot(up, frame.sun_direction), level = cloud_slab_sun(r.shell.model, mu_s);
    float mu = clamp_cos(dot(r.ray, up));
    vec3 sky = sky_irradiance(middle, up) / PI;
    CloudWeather w = cloud_weather_between(s.near_weather, s.far_weather, 0.5);
    float sides = cloud_sides(r.layer, w), facing = cloud_facing(level, sides);
    // The ground under a closed sky has what comes through it; under clouds with gaps, nearly all there is.
    vec4 transmitted = slab_transmittance(cloud_column(r.layer, w, 1.0) / level, level, r.shell.asymmetry);
    transmitted = mix(vec4(1.0, 0.0, 1.0, 0.0), transmitted, cloud_closed(r.layer, w));
    vec3 ground = CLOUD_GROUND / PI * (sun * (max(mu_s, 0.0) * (transmitted.x + transmitted.y)))
        + CLOUD_GROUND * transmitted.z * sky;
    return SegmentLight(up, sun, sky, ground, mu, facing, sides, cloud_harmonics(mu, mu_s + facing - level, r.nu));
}

// Mean over a run of the optical depth of light's whole way, in from the sun and out to the run's begin, as the depth
// that has the same transmittance. Across an even layer the way to the sun gets longer or shorter evenly; of clouds
// with sides nobody knows.
float mean_path_depth(CloudRun run, SegmentLight light, float sun_depth) {
    float slope = (1.0 - light.sides) * clamp(-light.mu / light.mu_s, -MOST_SLOPE, MOST_SLOPE);
    float first = max(sun_depth - slope * run.depth_before, 0.0),
        last = run.depth + max(sun_depth + slope * (run.depth - run.depth_before), 0.0);
    return min(first, last) - log(one_minus_exp_over(abs(last - first)));
}

// The run's light, and what it takes of what lies behind.
void add_run(inout March m, LayerRay r, Segment s, SegmentLight light, CloudRun run, CloudAround around) {
    float sun_depth = around.sun_depth, up = sun_depth * light.mu_s, down = around.under;
    float opacity = m.transmittance * (1.0 - exp(-run.depth)), scattered = 1.0 - r.lobes.peak,
        diffuse_transmittance = exp(-scattered * run.depth);
    float path_depth = mean_path_depth(run, light, sun_depth);
    float lit = m.transmittance * run.depth * exp(-path_depth);
    vec3 direct = light.sun
        * (r.single * lit * cloud_lobes_sum(r.lobes, path_depth - log(m.transmittance)));
    vec3 diffuse = light.sun * cloud_kept(up, light.sides, r.shell.asymmetry)
        * cloud_slab_light(r.shell.model, up, down, light.mu_s, light.harmonics)
        + (r.shell.albedo - r.lobes.peak)
        * cloud_from_around(light.sky, light.ground, up, down, light.mu, r.shell.asymmetry);
#ifdef CLOUD_ONCE
    // Light that was scattered once and no more, for who asks for it.
    direct = light.sun * (r.single * lit);
    diffuse = vec3(0.0);
#endif
    m.transmittance -= opacity;
    // What is left out where nothing behind is seen any more is as bright as the last of it. It comes in over some
    // depth: all at once, it would outline where the cloud is just so deep.
    diffuse_transmittance *= smoothstep(OPAQUE, NEARLY_OPAQUE, m.transmittance);
    m.radiance += mix(s.near_air.transmittance, s.far_air.transmittance, (run.t - s.begin) * s.per_metre)
        * (direct + m.diffuse_transmittance * (1.0 - diffuse_transmittance) / scattered * diffuse);
    m.diffuse_transmittance *= diffuse_transmittance;
    m.distance_sum += opacity * run.t;
}
