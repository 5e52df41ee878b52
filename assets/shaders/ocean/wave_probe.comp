// The sea's functions on an array of places: what systems/ocean/wave_probe.py asks.
#include "generated/bindings.glsl"
#include "generated/frame.glsl"
#include "generated/planet.glsl"
#include "generated/wave_questions.glsl"
#include "ocean/waves.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = QUESTION_BUFFER) readonly buffer Questions { WaveQuestion questions[]; };
layout(std430, binding = ANSWER_BUFFER) writeonly buffer Answers { WaveAnswer answers[]; };
layout(std430, binding = 2) readonly buffer Printed { PrintedWave printed[]; };
uniform int u_count;           // of questions
uniform int u_waves;           // how many there are
uniform int u_printed;         // 0: ours; 2018, 2019: as printed then
uniform float u_sea_radius_m;  // of the calm sea, for printed formulas
uniform float u_time_s;        // likewise

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(u_count)) return;
    WaveQuestion q = questions[i];
    if (u_printed == 0) {
        SeaPlace place = sea_place(q.foot_m);
        vec3 moved = sea_moved(place, q.depth_m, q.spacing_m);
        SeaSurface lies = sea_surface(place, q.depth_m, vec4(1e-12, 1e-12, 0.0, 1e-12));
        answers[i] = WaveAnswer(sea_vector(place, moved), lies.jacobian, lies.normal);
        return;
    }
    // Michelic 2018, equations 7, 8 and 10, and Michelic et al. 2019, as they stand, all in f32.
    vec3 v = q.direction, moved = vec3(0.0), normal = v;
    for (int k = 0; k < u_waves; ++k) {
        vec3 o = printed[k].origin;
        float a = printed[k].amplitude_m, w = printed[k].wave_number_per_m, phi = printed[k].speed_rad_s,
            steepness = printed[k].steepness;
        float l = u_printed == 2018 ? acos(clamp(dot(v, o), -1.0, 1.0)) * u_sea_radius_m
            : 2.0 * u_sea_radius_m * asin(min(0.5 * length(v - o), 1.0));
        vec3 d = cross(v, cross(v - o, v));
        float angle = w * l + phi * u_time_s;
        moved += v * (a * sin(angle)) + d * (steepness * a * cos(angle));
        normal -= v * (steepness * a * w * sin(angle)) + d * (a * w * cos(angle));
    }
    answers[i] = WaveAnswer(moved, 0.0, normalize(normal));
}
