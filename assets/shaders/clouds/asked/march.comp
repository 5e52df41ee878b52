// The march that pictures are made with, on an array of questions; systems/clouds/asked.py packs and unpacks it. Each
// question is a camera of its own: its place, and where the volumes of noise lie around it, come in float64 reduced.
//
// Where pictures read the optical depth towards the sun from maps, it is marched here.
struct Origins {
    vec3 broad, wide, fine, finest, fibre, veil, bend;
};
Origins g_origins;
#define CLOUD_ORIGIN(volume) g_origins.volume
#define CLOUD_GROUND u_ground
layout(location = 10) uniform float u_ground;   // its albedo

#include "generated/bindings.glsl"
#include "clouds/weather_march.glsl"
#include "clouds/shadowed_air.glsl"

layout(local_size_x = 16) in;

struct Question {
    vec4 place;        // unit up there; height above the reference sphere
    vec4 ray;          // unit; cosine to the zenith
    vec4 sun;          // unit; angular radius
    // how far the ray goes, angle that it stands for, squared sine of that to the zenith, how far it has come before
    vec4 more;
    vec4 origins[7];   // of the volumes, and in radii
};
layout(std430, binding = QUESTION_BUFFER) readonly buffer Questions { Question questions[]; };
layout(std430, binding = ANSWER_BUFFER) writeonly buffer Answers { vec4 answers[]; };

layout(location = 8) uniform int u_count;
layout(location = 9) uniform vec2 u_shafts;   // steps (0: no shafts), the first is about this long in metres

void cloud_sun_at(AirStep place) {}

float cloud_sun_left(AirStep place, float further) {
    vec3 point = place.point + place.ray * further;
    float mu_s = clamp_cos(dot(up_at(point), frame.sun_direction.xyz));
    return exp(-cloud_depth_marched(-1, point, altitude_of(point), mu_s, 0.5 * u_march.w, place.wide));
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(u_count)) return;
    Question q = questions[i];
    frame.camera_offset = vec4(0.0);
    frame.camera_zenith = frame.anchor_up = q.place;
    frame.sun_direction = q.sun;
    frame.sun_irradiance = frame.scale = vec4(1.0);
    g_origins = Origins(q.origins[0].xyz, q.origins[1].xyz, q.origins[2].xyz, q.origins[3].xyz, q.origins[4].xyz,
        q.origins[5].xyz,
        q.origins[6].xyz);
    pixel_rad = q.more.y;
    shell_sine2 = q.more.z;
    ray_walked = q.more.w;
    March m = march_clouds(q.ray.xyz, q.ray.w, q.more.x, 0.5);
    float taken = 1.0 - m.open, before = taken > 1e-4 ? m.sum / taken : NOT_ALL;
    ShadowedAir dark = shadowed_air(q.ray.xyz, q.ray.w, q.more.x, before, m.open, int(u_shafts.x), u_shafts.y, 0.5);
    Air behind = air_from_camera(q.ray.xyz * q.more.x);
    vec3 light = m.light + m.open * behind.in_scatter - (dark.any ? dark.light : vec3(0.0));
    answers[2u * i] = vec4(max(light, 0.0), 0.0);
    answers[2u * i + 1u] = vec4(m.open * behind.transmittance, 0.0);
}
