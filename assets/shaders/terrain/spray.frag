// Spray of waterfalls before what is drawn: droplets in two Gaussian clouds, whose optical depth along a ray is known
// in closed form. Where it is thin each droplet scatters the sun once, forward for the most part, and in a bow; where
// it is dense it is as white as foam.
//
//   PUFF, FINER   size of puffs, in heights of the fall, and how many times finer the second octave is
#include "common/camera.glsl"
#include "common/constants.glsl"
#include "common/noise.glsl"
#include "generated/bindings.glsl"
#include "terrain/spray.glsl"

layout(binding = DEPTH_UNIT) uniform sampler2D u_depth;
uniform vec3 u_bow_rad;   // the primary bow's angle from the shadow of the eye, in each wavelength

flat in vec4 v_foot;
flat in vec4 v_up;
flat in vec4 v_way;
flat in float v_seed;
flat in vec4 v_risen;
flat in vec4 v_beam, v_diffuse, v_dense, v_loss, v_air;   // SprayLight
layout(location = 0) out vec4 o_light;   // premultiplied

const float FORWARD = 0.75;                  // asymmetry of droplets
const float BOW_RAD = 0.011, BOW = 0.055;    // the bow's deviation, with the sun's disc in it, and its phase function

// One octave around a place in cells, which has risen by whole cells and a part of one.
float puff(vec3 cells, vec2 risen) {
    cells += v_seed - vec3(0.0, 0.0, risen.y);
    return gradient_noise_value(ivec3(floor(cells)) - ivec3(0, 0, int(risen.x)), fract(cells));
}

// How much more or less there is at a place, m from the foot: two octaves that rise, the finer one as far as a pixel
// shows it.
float puffs(vec3 place, float width_m, float pixel_m) {
    float fine = 0.9 * clamp(2.0 - 4.0 * pixel_m * FINER / width_m, 0.0, 1.0);
    return clamp(1.0 + 1.5 * puff(place / width_m, v_risen.xy) + fine * puff(place * (FINER / width_m), v_risen.zw),
        0.0, 2.0);
}

void main() {
    Spray s = Spray(v_foot.xyz, v_up.xyz, v_way.xyz, v_up.w, v_way.w, v_foot.w, v_seed);
    vec3 whole = view_ray(ndc_of_pixel(gl_FragCoord.xy));
    float per_forward = length(whole), depth = texelFetch(u_depth, ivec2(gl_FragCoord.xy), 0).r;
    vec3 ray = whole / per_forward;
    float end = depth > 0.0 ? forward_distance(depth) * per_forward : 1e9;
    mat3 turn = transpose(mat3(s.way, cross(s.up, s.way), s.up));
    vec3 eye = turn * -s.foot, going = turn * ray;
    float mean_m, optical = spray_depth(s, eye, going, end, mean_m);
    optical *= puffs(eye + going * mean_m, PUFF * s.height, mean_m * frame.pixel_rad);
    float nu = dot(ray, frame.sun_direction), g = FORWARD, opacity = 1.0 - exp(-optical);
    float once = (1.0 - g * g) / (4.0 * PI * pow(1.0 + g * g - 2.0 * g * nu, 1.5));
    vec3 off = (acos(clamp(-nu, -1.0, 1.0)) - u_bow_rad) / BOW_RAD;
    vec3 thin = v_diffuse.rgb + v_beam.rgb * (once + BOW * exp(-0.5 * off * off));
    vec3 left = exp(-v_loss.rgb * mean_m);
    vec3 light = mix(thin, max(thin, v_dense.rgb), opacity) * left + v_air.rgb * (1.0 - left);
    o_light = vec4(light * opacity * frame.hdr_per_radiance, opacity);
}
