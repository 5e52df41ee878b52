// The sea's functions on an array of places: what systems/ocean/wave_probe.py asks.
#include "generated/bindings.glsl"
#include "generated/frame.glsl"
#include "generated/planet.glsl"
#include "generated/wave_questions.glsl"
#include "ocean/waves.glsl"
#include "ocean/paper/record.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = QUESTION_BUFFER) readonly buffer Questions { WaveQuestion questions[]; };
layout(std430, binding = ANSWER_BUFFER) writeonly buffer Answers { WaveAnswer answers[]; };
layout(std430, binding = 2) readonly buffer Records { WaveRecord records[]; };
uniform int u_count;           // of questions
uniform int u_waves;           // how many there are
uniform int u_printed;         // 0: ours; 2018, 2019: as printed then
uniform bool u_records;        // ours from records at the anchor
uniform float u_sea_radius_m;  // of the calm sea, for printed formulas
uniform float u_time_s;        // likewise

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(u_count)) return;
    WaveQuestion q = questions[i];
    if (u_printed == 0 && !u_records) {
        SeaPlace place = sea_place(q.foot_m);
        vec3 moved = sea_moved(place, q.depth_m, q.spacing_m);
        SeaSurface lies = sea_surface(place, q.depth_m, vec4(1e-12, 1e-12, 0.0, 1e-12));
        answers[i] = WaveAnswer(sea_vector(place, moved), lies.jacobian, lies.normal);
        return;
    }
    if (u_records) {
        SeaPlace place = sea_place(q.foot_m);
        vec3 moved = vec3(0.0);
        SeaSums sums = SeaSums(vec2(0.0), vec3(0.0), vec3(0.0));
        for (int k = 0; k < u_waves; ++k) {
            Wave at = paper_wave(records[k]);
            SeaWave wave = k < sea_waves.far_count ? sea_far_wave(place, at) : sea_near_wave(place, at);
            moved += sea_wave_moved(wave, q.depth_m, q.spacing_m);
            sea_add(sums, wave, vec4(1e-12, 1e-12, 0.0, 1e-12), q.depth_m);
        }
        SeaSurface lies = sea_lie(place, sums);
        answers[i] = WaveAnswer(sea_vector(place, moved), lies.jacobian, lies.normal);
        return;
    }
    // Michelic 2018, equations 7, 8 and 10, and Michelic et al. 2019, as they stand, all in f32.
    vec3 v = q.direction, moved = vec3(0.0), normal = v;
    for (int k = 0; k < u_waves; ++k) {
        WaveRecord at = records[k];
        vec3 o = vec3(at.origin_x, at.origin_y, at.origin_z);
        float a = at.amplitude_m, w = at.wave_number, phi = at.turn, steepness = at.steepness;
        float l = paper_arc(u_printed, v, o, u_sea_radius_m);
        vec3 d = cross(v, cross(v - o, v));
        float angle = w * l + phi * u_time_s;
        moved += v * (a * sin(angle)) + d * (steepness * a * cos(angle));
        normal -= v * (steepness * a * w * sin(angle)) + d * (a * w * cos(angle));
    }
    answers[i] = WaveAnswer(moved, 0.0, normalize(normal));
}
