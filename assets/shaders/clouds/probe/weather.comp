// The march that pictures are made with, on an array of questions (systems/clouds/questions.py). Each is a camera of
// its own: its place, and where the volumes of noise lie around it, come in float64 reduced.
//
// Where pictures read the optical depth towards the sun from maps, it is marched here.
#include "generated/weather_question.glsl"
NoiseOrigins g_origins;
#define CLOUD_ORIGIN(volume) g_origins.volume
#define CLOUD_GROUND u_ground
layout(location = 10) uniform float u_ground;   // albedo

#include "generated/bindings.glsl"
#include "clouds/weather_march.glsl"
#include "clouds/shadowed_air.glsl"

layout(local_size_x = 16) in;

struct Answer {
    vec3 radiance, transmittance;
};
layout(std430, binding = QUESTION_BUFFER) readonly buffer Questions { WeatherQuestion questions[]; };
layout(std430, binding = ANSWER_BUFFER) writeonly buffer Answers { Answer answers[]; };

layout(location = 8) uniform int u_count;
layout(location = 9) uniform int u_shaft_steps;   // 0: no shafts
layout(location = 11) uniform float u_first_shaft_step;   // about as long, in metres

void cloud_sun_at(AirStep place) {}

float cloud_sun_left(AirStep place, float further) {
    vec3 point = place.point + place.ray * further;
    float mu_s = clamp_cos(dot(up_at(point), frame.sun_direction));
    return exp(-cloud_depth_marched(-1, point, altitude_of(point), mu_s, 0.5 * u_sun_steps, place.footprint_m));
}

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(u_count)) return;
    WeatherQuestion q = questions[i];
    frame.camera_offset_m = vec3(0.0);
    frame.camera_zenith = frame.anchor_up = q.up;
    frame.camera_altitude_m = frame.anchor_height_m = q.height_m;
    frame.sun_direction = q.sun;
    frame.sun_radius_rad = q.sun_radius_rad;
    frame.sun_irradiance = vec3(1.0);
    frame.hdr_per_radiance = frame.radiance_per_hdr = 1.0;
    g_origins = q.origins;
    pixel_rad = q.pixel_rad;
    shell_sine2 = q.sine2;
    ray_skipped_m = q.skipped_m;
    March m = march_clouds(q.ray, q.mu, q.end_m, 0.5);
    ShadowedAir dark = shadowed_air(q.ray, q.mu, q.end_m, cloud_mean_distance(m), m.transmittance, u_shaft_steps,
        u_first_shaft_step, 0.5);
    Air behind = air_from_camera(q.ray * q.end_m);
    vec3 radiance = m.radiance + m.transmittance * behind.in_scatter - (dark.shadowed ? dark.light : vec3(0.0));
    answers[i].radiance = max(radiance, 0.0);
    answers[i].transmittance = m.transmittance * behind.transmittance;
}
