// The sea's functions on an array of places: what systems/ocean/wave_probe.py asks.
#include "generated/bindings.glsl"
#include "generated/frame.glsl"
#include "generated/planet.glsl"
#include "ocean/waves.glsl"

layout(local_size_x = 64) in;
struct Question {
    vec4 place;     // foot offset from the anchor, m; depth, m
    vec4 seen;      // unit direction in planet axes (for the printed formulas); distance of samples, m
};
layout(std430, binding = QUESTION_BUFFER) readonly buffer Questions { Question questions[]; };
layout(std430, binding = ANSWER_BUFFER) writeonly buffer Answers { vec4 answers[]; };   // movement, Jacobian; normal, 0
layout(std430, binding = 2) readonly buffer Printed { vec4 printed[]; };    // origin, A; wave number, phi, Q, 0
uniform ivec4 u_mode;    // number of questions; 0: ours, 2018, 2019 as printed; waves
uniform vec2 u_printed;  // radius of the calm sea, time in s

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(u_mode.x)) return;
    Question q = questions[i];
    if (u_mode.y == 0) {
        SeaPlace place = sea_place(q.place.xyz);
        vec3 moved = sea_moved(place, q.place.w, q.seen.w);
        SeaSurface lies = sea_surface(place, q.place.w, vec4(1e-12, 1e-12, 0.0, 1e-12));
        answers[2u * i] = vec4(sea_vector(place, moved), lies.jacobian);
        answers[2u * i + 1u] = vec4(lies.normal, 0.0);
        return;
    }
    // Michelic 2018, equations 7, 8 and 10, and Michelic et al. 2019, as they stand, all in f32.
    vec3 v = q.seen.xyz, moved = vec3(0.0), normal = v;
    for (int k = 0; k < u_mode.z; ++k) {
        vec3 o = printed[2 * k].xyz;
        float a = printed[2 * k].w, w = printed[2 * k + 1].x, phi = printed[2 * k + 1].y,
            steepness = printed[2 * k + 1].z;
        float l = u_mode.y == 2018 ? acos(clamp(dot(v, o), -1.0, 1.0)) * u_printed.x
            : 2.0 * u_printed.x * asin(min(0.5 * length(v - o), 1.0));
        vec3 d = cross(v, cross(v - o, v));
        float angle = w * l + phi * u_printed.y;
        moved += v * (a * sin(angle)) + d * (steepness * a * cos(angle));
        normal -= v * (steepness * a * w * sin(angle)) + d * (a * w * cos(angle));
    }
    answers[2u * i] = vec4(moved, 0.0);
    answers[2u * i + 1u] = vec4(normalize(normal), 0.0);
}
