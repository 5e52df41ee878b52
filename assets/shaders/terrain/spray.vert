// A rectangle around each fall's spray, all of the picture for a camera that is close; and the light there, which
// changes little from pixel to pixel.
#include "common/camera.glsl"
#include "common/constants.glsl"
#include "contract/air.glsl"
#include "contract/skylight.glsl"
#include "contract/sun_visibility.glsl"
#include "terrain/spray.glsl"

in vec4 in_foot;   // xyz, density
in vec4 in_up;     // xyz, height
in vec4 in_way;    // xyz, half width
in float in_seed;

flat out vec4 v_foot;
flat out vec4 v_up;
flat out vec4 v_way;
flat out float v_seed;
flat out vec3 v_beam;      // the sun's light on a surface across it
flat out vec3 v_diffuse;   // radiance of light that comes evenly from all sides, by what a droplet scatters
flat out vec3 v_dense;     // radiance of spray that is as white as foam
flat out vec3 v_loss;      // of the air before it, 1/m
flat out vec3 v_air;       // and that air's source

const float SCATTERED = 0.98;       // albedo of droplets
const float WHITE = 0.72;           // of spray through which nothing is seen
const float NEAREST_AIR_M = 100.0;  // from nearer both would be differences of rounded numbers

// Around all of it, low (xy) and high (zw); of the whole picture if some is beside the camera or behind.
vec4 spray_bounds(Spray s) {
    vec3 low = vec3(3e38), high = vec3(-3e38), across = cross(s.up, s.way);
    for (int k = 0; k < SPRAY_CLOUDS; ++k) {
        vec4 middle;
        vec3 deviation;
        spray_cloud(s, k, middle, deviation);
        low = min(low, middle.xyz - SPRAY_DEVIATIONS * deviation);
        high = max(high, middle.xyz + SPRAY_DEVIATIONS * deviation);
    }
    vec4 bounds = vec4(1e9, 1e9, -1e9, -1e9);
    int ahead = 0;
    for (int k = 0; k < 8; ++k) {
        vec3 at = mix(low, high, vec3(k & 1, (k >> 1) & 1, k >> 2));
        vec4 clip = clip_position(s.foot + s.way * at.x + across * at.y + s.up * at.z);
        ahead += clip.w > 0.1 ? 1 : 0;
        vec2 ndc = clip.xy / max(clip.w, 0.1);
        bounds = vec4(min(bounds.xy, ndc), max(bounds.zw, ndc));
    }
    return ahead == 8 ? bounds : ahead == 0 ? vec4(-2.0) : vec4(-1.0, -1.0, 1.0, 1.0);
}

void main() {
    v_foot = in_foot;
    v_up = in_up;
    v_way = in_way;
    v_seed = in_seed;
    Spray s = Spray(in_foot.xyz, in_up.xyz, in_way.xyz, in_up.w, in_way.w, in_foot.w, in_seed);
    vec4 bounds = clamp(spray_bounds(s), -2.0, 2.0);
    gl_Position = vec4(mix(bounds.xy, bounds.zw, vec2(gl_VertexID & 1, gl_VertexID >> 1)), 0.5, 1.0);
    // Lit half by what reaches its pool and half by what reaches its top.
    vec3 pool = s.foot + 0.4 * s.height * s.way, sun = frame.sun_direction;
    float seen = 0.5 * (sun_visibility(pool + 0.3 * s.height * s.up) + sun_visibility(pool + 0.8 * s.height * s.up));
    v_beam = frame.sun_irradiance * seen * air_to_space(pool, sun);
    float above = max(dot(sun, s.up), 0.0);
    vec3 sky = skylight(pool, s.up);
    // The sky above, and below it water that throws back some of the sun.
    v_diffuse = SCATTERED * (sky + 0.3 * above * v_beam) / (2.0 * PI);
    v_dense = WHITE * (v_beam * max(0.25 + 0.75 * above, 0.0) + sky) / PI;
    float distance_m = max(length(pool), NEAREST_AIR_M);
    Air between = air_from_camera(pool * (distance_m / max(length(pool), 1e-3)));
    vec3 left = clamp(between.transmittance, 1e-30, 1.0);
    v_loss = -log(left) / distance_m;
    v_air = between.in_scatter / max(1.0 - left, 1e-7);
}
