// Light that the air does not scatter because clouds keep the sun from it: taken from what each ray of the clouds adds to the
// picture, whose air is lit as if there were none. What is left of the air's light is between shafts.
//
// Only light that would be scattered once is in clouds' shadow; what has been scattered before comes from all sides.
#include "clouds/view_ray.glsl"
#include "clouds/sun_depth.glsl"
#include "common/planet_shadow.glsl"
#include "contract/air.glsl"
#include "contract/air_point.glsl"

layout(local_size_x = 8, local_size_y = 4) in;
layout(binding = 0, rgba32f) uniform image2D u_rays;
layout(binding = 1, r32f) uniform image2D u_distance;
layout(location = 0) uniform vec3 u_march;   // steps; how much of the shadow counts; the first step is about this long in metres

const float CLEAR = 1e-3;

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, imageSize(u_rays)))) return;
    ViewRay v = cloud_view_ray(at);
    vec3 ray = v.ray;
    float nu = clamp_cos(dot(ray, frame.sun_direction.xyz));
    vec2 span = min(shell_crossings(v.mu, cloud_view.counts.z), vec2(v.end));

    vec4 clouds = imageLoad(u_rays, at);
    float before = imageLoad(u_distance, at).r, soft = u_march.z;
    int steps = span.y - span.x > 1.0 ? int(u_march.x) : 0;
    // Steps grow with distance: the air's transmittance, and what a pixel tells apart, do so as well.
    float growth = log((span.y + soft) / (span.x + soft));
    vec3 passed = vec3(0.0), extinction = vec3(0.0), lost = vec3(0.0), all = vec3(0.0);
    float last = span.x, sum = 0.0;
    for (int i = 0; i < steps; ++i) {
        float share = (float(i) + v.shift) / float(steps), t = (span.x + soft) * exp(growth * share) - soft;
        float length_m = (t + soft) * growth / float(steps);
        vec3 point = ray * t, up = up_at(point);
        float altitude = altitude_of(point), mu_s = clamp_cos(dot(up, frame.sun_direction.xyz));
        AirPoint air = air_point(max(altitude, 0.0), clamp_cos(dot(ray, up)), mu_s, nu, 0.0);
        passed += (i == 0 ? air.extinction : 0.5 * (extinction + air.extinction)) * (t - last);
        extinction = air.extinction;
        last = t;
        float dark = (1.0 - cloud_sunlight(point, altitude, mu_s, 0.5 * length_m).x) * (t < before ? 1.0 : clouds.a);
        float seen = sun_visibility_of_sphere(altitude, mu_s, frame.sun_direction.w);
        vec3 clear = air.direct * exp(-passed - air.sun_depth) * (seen * length_m), part = clear * dark;
        all += clear;
        lost += part;
        sum += t * part.g;
    }
    for (int once = lost.g > 0.0 ? 0 : 1; once < 1; ++once) {
        // Before the air that is marched through, the camera may be above it.
        Air near = air_from_camera(ray * span.x), far = air_from_camera(ray * span.y);
        vec3 light = frame.sun_irradiance.rgb * near.transmittance, most = max(far.in_scatter - near.in_scatter, 0.0);
        // Few steps may find more light than the tables have: no more than that is there to be taken.
        light *= u_march.y * lost * min(most / max(light * all, 1e-30), 1.0) * frame.scale.x;
        imageStore(u_rays, at, vec4(clouds.rgb - light, clouds.a));
        // Where there is nothing else to follow from frame to frame, the shafts are.
        if (1.0 - clouds.a < CLEAR) imageStore(u_distance, at, vec4(sum / lost.g));
    }
}
