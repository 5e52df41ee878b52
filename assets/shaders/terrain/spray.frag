// Spray of waterfalls before what is drawn: droplets in two Gaussian clouds, whose optical depth along a ray is known
// in closed form. Where it is thin each droplet scatters the sun once, forward for the most part, and in a bow; where it
// is dense it is as white as foam.
#include "common/camera.glsl"
#include "common/constants.glsl"
#include "common/noise.glsl"
#include "contract/air.glsl"
#include "contract/skylight.glsl"
#include "contract/sun_visibility.glsl"
#include "terrain/spray.glsl"

layout(binding = DEPTH_UNIT) uniform sampler2D u_depth;
uniform vec3 u_bow_cosine;   // cosine of the primary bow's angle from the shadow of the eye, in each wavelength

flat in vec4 v_foot;
flat in vec4 v_up;
flat in vec4 v_way;
flat in float v_seed;
layout(location = 0) out vec4 o_light;   // premultiplied

const float FORWARD = 0.75, SCATTERED = 0.98;   // asymmetry and albedo of droplets
const float BOW_RAD = 0.011, BOW = 0.055;       // the bow's deviation, with the sun's disc in it, and its phase function
const float RISE_M_S = 1.6;                     // of puffs

// Odd rational approximation of erf, to 5e-4 (Abramowitz and Stegun 1964, 7.1.27).
float erf_of(float x) {
    float a = abs(x), d = 1.0 + a * (0.278393 + a * (0.230389 + a * (0.000972 + a * 0.078108)));
    d *= d;
    return sign(x) * (1.0 - 1.0 / (d * d));
}

// How much more or less there is at a place, m from the foot: two octaves that rise.
float puffs(vec3 place, float width_m) {
    float sum = 1.0;
    for (int k = 0; k < 2; ++k) {
        float per_m = (k == 0 ? 1.0 : 3.1) / width_m;
        vec3 at = (place - vec3(0.4, 0.0, 1.0) * (RISE_M_S * frame.time_s)) * per_m + v_seed;
        vec3 cell = floor(at);
        sum += (k == 0 ? 1.5 : 0.9) * gradient_noise_value(ivec3(cell), at - cell);
    }
    return clamp(sum, 0.0, 2.0);
}

void main() {
    Spray s = Spray(v_foot.xyz, v_up.xyz, v_way.xyz, v_up.w, v_way.w, v_foot.w, v_seed);
    vec2 ndc = ndc_of_pixel(gl_FragCoord.xy);
    vec3 whole = view_ray(ndc), ray = normalize(whole), across = cross(s.up, s.way);
    float depth = texelFetch(u_depth, ivec2(gl_FragCoord.xy), 0).r;
    float end = depth > 0.0 ? forward_distance(depth) * length(whole) : 1e9;
    mat3 turn = transpose(mat3(s.way, across, s.up));
    vec3 eye = turn * -s.foot, going = turn * ray;
    float optical = 0.0, mean_m = 0.0;
    for (int k = 0; k < SPRAY_CLOUDS; ++k) {
        vec4 middle;
        vec3 deviation;
        spray_cloud(s, k, middle, deviation);
        vec3 from = (eye - middle.xyz) / deviation, along = going / deviation;
        float a = dot(along, along), b = dot(from, along) / a, c = dot(from, from) - a * b * b;
        float root = sqrt(0.5 * a), nearest = clamp(-b, 0.0, end);
        float found = middle.w * exp(-0.5 * max(c, 0.0)) * (0.8862269 / root)
            * (erf_of((end + b) * root) - erf_of(b * root));
        found *= puffs(eye + going * nearest, 0.45 * s.height);
        optical += found;
        mean_m += found * nearest;
    }
    if (optical < 1e-4) discard;
    mean_m /= optical;
    vec3 point = ray * mean_m, sun = frame.sun_direction;
    vec3 zenith = up_at(point);
    float nu = dot(ray, sun), g = FORWARD, opacity = 1.0 - exp(-optical);
    float once = (1.0 - g * g) / (4.0 * PI * pow(1.0 + g * g - 2.0 * g * nu, 1.5));
    vec3 off = (acos(clamp(-nu, -1.0, 1.0)) - acos(u_bow_cosine)) / BOW_RAD;
    vec3 phase = once + BOW * exp(-0.5 * off * off);
    vec3 beam = frame.sun_irradiance * sun_visibility(point) * air_to_space(point, sun);
    vec3 sky = skylight(point, zenith);
    // Once, from a sky above and water below that throws back some of both; and as a white surface.
    vec3 thin = SCATTERED * (beam * phase + (sky + 0.3 * beam * max(dot(sun, zenith), 0.0)) / (2.0 * PI));
    vec3 dense = 0.72 * (beam * max(0.25 + 0.75 * dot(sun, zenith), 0.0) + sky) / PI;
    Air between = air_from_camera(point);
    vec3 light = mix(thin, max(thin, dense), opacity) * between.transmittance + between.in_scatter;
    o_light = vec4(light * opacity * frame.hdr_per_radiance, opacity);
}
