// Light that the air along a ray does not scatter because clouds keep the sun from it: of what would be scattered once.
//
// Whoever includes this defines cloud_sun_at(place), called once a step, and then cloud_sun_left(place, further): the
// share of the sunlight that clouds leave so many metres further along the ray than that.
#include "clouds/shells.glsl"
#include "common/planet_shadow.glsl"
#include "contract/air.glsl"
#include "contract/air_point.glsl"

struct AirStep {
    vec3 point, ray, up;
    float altitude;
    float mu, mu_s, nu;   // cosines of the ray and of the sun to the zenith there, and between the two
    float footprint_m;    // of a sample of the shadow
};

void cloud_sun_at(AirStep place);
float cloud_sun_left(AirStep place, float further);

const int SHADOW_SAMPLES = 3;   // in a step

struct ShadowedAir {
    vec3 light;      // radiance to be taken off, towards the camera
    float distance_m;  // its mean distance; meaningless where there is no such light
    bool shadowed;
};

// Of each sample in a step, of where its part of the step begins, and one over how long that is: from the step's
// middle, over the middle's distance.
struct StepSamples {
    float offset[SHADOW_SAMPLES], begin[SHADOW_SAMPLES], per_length[SHADOW_SAMPLES];
};

// growth: logarithm of a step's end over its begin.
StepSamples step_samples(float growth, float jitter) {
    StepSamples s;
    for (int k = 0; k < SHADOW_SAMPLES; ++k) {
        s.offset[k] = exp(growth * ((float(k) + jitter) / float(SHADOW_SAMPLES) - 0.5)) - 1.0;
        s.begin[k] = exp(growth * (float(k) / float(SHADOW_SAMPLES) - 0.5)) - 1.0;
        s.per_length[k] = 1.0
            / max(exp(growth * (float(k + 1) / float(SHADOW_SAMPLES) - 0.5)) - 1.0 - s.begin[k], 1e-6);
    }
    return s;
}

// end: of the ray; cloud_m, transmittance: of the clouds, their mean distance; most: steps; first_m: the first is about
// this long; jitter: 0..1, of the samples.
ShadowedAir shadowed_air(
    vec3 ray, float mu, float end, float cloud_m, float transmittance, int most, float first_m, float jitter
) {
    float nu = clamp_cos(dot(ray, frame.sun_direction));
    vec2 interval = min(shell_crossings(mu, cloud_view.highest_m), vec2(end));
    bool any_air = most > 0 && interval.y - interval.x > 1.0;
    int steps = any_air ? most : 1, i = 0;
    // Steps grow with distance: the air's transmittance, and what a pixel tells apart, do so as well.
    float growth = any_air ? log((interval.y + first_m) / (interval.x + first_m)) / float(steps) : 0.0;
    StepSamples samples = step_samples(growth, jitter);
    vec3 depth = vec3(0.0), extinction = vec3(0.0), lost = vec3(0.0);
    float last = interval.x, sum = 0.0;
    do {
        // The light that is left can be a small part of what there is without clouds: chance in that sum would be all
        // that is seen. At the steps' middles it is exact to a few thousandths. Chance is left to the shadow.
        float away = (interval.x + first_m) * exp(growth * (float(i) + 0.5)), t = away - first_m;
        float length_m = away * growth;
        vec3 point = ray * t, up = up_at(point);
        float altitude = altitude_of(point);
        AirStep place = AirStep(point, ray, up, altitude, clamp_cos(dot(ray, up)),
            clamp_cos(dot(up, frame.sun_direction)), nu,
            0.5 * length_m / float(SHADOW_SAMPLES));
        AirPoint air = air_point(max(altitude, 0.0), place.mu, place.mu_s, nu, 0.0);
        depth += (i == 0 ? air.extinction : 0.5 * (extinction + air.extinction)) * (t - last);
        extinction = air.extinction;
        last = t;
        cloud_sun_at(place);
        float dark = 0.0, left = (cloud_m - t) / away;
        for (int k = 0; k < SHADOW_SAMPLES; ++k) {
            float further = away * samples.offset[k];
            // Just as much of the air as there is before the clouds: a sample more or less would take more light off
            // than air there has.
            float clear = clamp((left - samples.begin[k]) * samples.per_length[k], 0.0, 1.0);
            dark += (1.0 - cloud_sun_left(place, further)) * mix(transmittance, 1.0, clear);
        }
        float shadowed = sun_visibility_of_sphere(altitude, place.mu_s, frame.sun_radius_rad) * dark
            / float(SHADOW_SAMPLES);
        vec3 part = air.direct * exp(-depth - air.sun_depth) * (shadowed * length_m);
        lost += part;
        sum += t * part.g;
    } while (++i < steps);
    // Before the air that is marched through, the camera may be above it.
    vec3 light = frame.sun_irradiance * air_from_camera(ray * interval.x).transmittance * lost;
    return ShadowedAir(light, sum / max(lost.g, 1e-30), lost.g > 0.0);
}
