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
    float wide;           // what a look at the shadow stands for, in metres
};

void cloud_sun_at(AirStep place);
float cloud_sun_left(AirStep place, float further);

const int LOOKS = 3;   // at the shadow, in a step

struct ShadowedAir {
    vec3 light;      // radiance to be taken off, towards the camera
    float distance;  // its mean distance; meaningless where there is no such light
    bool any;
};

// end: of the ray; before, open: mean distance of the clouds and what they leave; soft: the first step is about this
// long, in metres; shift: 0..1, of the looks.
ShadowedAir shadowed_air(vec3 ray, float mu, float end, float before, float open, int most, float soft, float shift) {
    float nu = clamp_cos(dot(ray, frame.sun_direction.xyz));
    vec2 span = min(shell_crossings(mu, cloud_view.highest_m), vec2(end));
    bool any_air = most > 0 && span.y - span.x > 1.0;
    int steps = any_air ? most : 1, i = 0;
    // Steps grow with distance: the air's transmittance, and what a pixel tells apart, do so as well.
    float growth = any_air ? log((span.y + soft) / (span.x + soft)) / float(steps) : 0.0;
    // Of each look, of where what it stands for begins, and one over how long that is: from the step's middle, over the
    // middle's distance.
    float aside[LOOKS], begins[LOOKS], per_length[LOOKS];
    for (int k = 0; k < LOOKS; ++k) {
        aside[k] = exp(growth * ((float(k) + shift) / float(LOOKS) - 0.5)) - 1.0;
        begins[k] = exp(growth * (float(k) / float(LOOKS) - 0.5)) - 1.0;
        per_length[k] = 1.0 / max(exp(growth * (float(k + 1) / float(LOOKS) - 0.5)) - 1.0 - begins[k], 1e-6);
    }
    vec3 passed = vec3(0.0), extinction = vec3(0.0), lost = vec3(0.0);
    float last = span.x, sum = 0.0;
    do {
        // The light that is left can be a small part of what there is without clouds: chance in that sum would be all
        // that is seen. At the steps' middles it is exact to a few thousandths. Chance is left to the shadow.
        float away = (span.x + soft) * exp(growth * (float(i) + 0.5)), t = away - soft, length_m = away * growth;
        vec3 point = ray * t, up = up_at(point);
        float altitude = altitude_of(point);
        AirStep place = AirStep(point, ray, up, altitude, clamp_cos(dot(ray, up)),
            clamp_cos(dot(up, frame.sun_direction.xyz)), nu,
            0.5 * length_m / float(LOOKS));
        AirPoint air = air_point(max(altitude, 0.0), place.mu, place.mu_s, nu, 0.0);
        passed += (i == 0 ? air.extinction : 0.5 * (extinction + air.extinction)) * (t - last);
        extinction = air.extinction;
        last = t;
        cloud_sun_at(place);
        float dark = 0.0, left = (before - t) / away;
        for (int k = 0; k < LOOKS; ++k) {
            float further = away * aside[k];
            // Just as much of the air as there is before the clouds: a look more or less would take more light off than
            // air there has.
            float clear = clamp((left - begins[k]) * per_length[k], 0.0, 1.0);
            dark += (1.0 - cloud_sun_left(place, further)) * mix(open, 1.0, clear);
        }
        float seen = sun_visibility_of_sphere(altitude, place.mu_s, frame.sun_direction.w) * dark / float(LOOKS);
        vec3 part = air.direct * exp(-passed - air.sun_depth) * (seen * length_m);
        lost += part;
        sum += t * part.g;
    } while (++i < steps);
    // Before the air that is marched through, the camera may be above it.
    vec3 light = frame.sun_irradiance.rgb * air_from_camera(ray * span.x).transmittance * lost;
    return ShadowedAir(light, sum / max(lost.g, 1e-30), lost.g > 0.0);
}
