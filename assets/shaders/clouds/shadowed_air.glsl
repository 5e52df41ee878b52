// Light that the air along a ray does not scatter because clouds keep the sun from it: of what would be scattered once.
//
// Whoever includes this defines cloud_sun_left(point, altitude, mu_s, wide_m): the share of the sunlight that clouds leave.
#include "clouds/shells.glsl"
#include "common/planet_shadow.glsl"
#include "contract/air.glsl"
#include "contract/air_point.glsl"

float cloud_sun_left(vec3 point, float altitude, float mu_s, float wide_m);

const float MOST_ONCE = 0.8;   // of the air's light, scattered once: towards a low sun, where that share is largest

struct ShadowedAir {
    vec3 light;      // radiance to be taken off, towards the camera
    float distance;  // its mean distance; meaningless where there is no such light
    bool any;
};

// end: of the ray; before, open: mean distance of the clouds and what they leave; soft: the first step is about this long, in
// metres; shift: 0..1, of the steps.
ShadowedAir shadowed_air(vec3 ray, float mu, float end, float before, float open, int most, float soft, float shift) {
    float nu = clamp_cos(dot(ray, frame.sun_direction.xyz));
    vec2 span = min(shell_crossings(mu, cloud_view.counts.z), vec2(end));
    int steps = span.y - span.x > 1.0 ? most : 0;
    // Steps grow with distance: the air's transmittance, and what a pixel tells apart, do so as well.
    float growth = log((span.y + soft) / (span.x + soft));
    vec3 passed = vec3(0.0), extinction = vec3(0.0), lost = vec3(0.0), all = vec3(0.0);
    float last = span.x, sum = 0.0;
    for (int i = 0; i < steps; ++i) {
        float share = (float(i) + shift) / float(steps), t = (span.x + soft) * exp(growth * share) - soft;
        float length_m = (t + soft) * growth / float(steps);
        vec3 point = ray * t, up = up_at(point);
        float altitude = altitude_of(point), mu_s = clamp_cos(dot(up, frame.sun_direction.xyz));
        AirPoint air = air_point(max(altitude, 0.0), clamp_cos(dot(ray, up)), mu_s, nu, 0.0);
        passed += (i == 0 ? air.extinction : 0.5 * (extinction + air.extinction)) * (t - last);
        extinction = air.extinction;
        last = t;
        float dark = (1.0 - cloud_sun_left(point, altitude, mu_s, 0.5 * length_m)) * (t < before ? 1.0 : open);
        float seen = sun_visibility_of_sphere(altitude, mu_s, frame.sun_direction.w);
        vec3 clear = air.direct * exp(-passed - air.sun_depth) * (seen * length_m), part = clear * dark;
        all += clear;
        lost += part;
        sum += t * part.g;
    }
    ShadowedAir found = ShadowedAir(vec3(0.0), 0.0, lost.g > 0.0);
    for (int once = found.any ? 0 : 1; once < 1; ++once) {
        // Before the air that is marched through, the camera may be above it.
        Air near = air_from_camera(ray * span.x), far = air_from_camera(ray * span.y);
        vec3 light = frame.sun_irradiance.rgb * near.transmittance, there = max(far.in_scatter - near.in_scatter, 0.0);
        // Few steps may find more light than the tables have, and of that a part was scattered more than once and comes from all
        // sides: no more than the rest is there to be taken.
        found.light = light * lost * min(MOST_ONCE * there / max(light * all, 1e-30), 1.0);
        found.distance = sum / lost.g;
    }
    return found;
}
