// What a probe asks and is answered; systems/atmosphere/probe.py packs and unpacks it.
#include "generated/bindings.glsl"
layout(local_size_x = 16) in;

struct Question {
    vec4 camera, span, shape;   // as AirView in view.glsl
    vec4 ray;                   // mu, sine, cosine of the azimuth from the sun, nu
    vec4 more;                  // distance (negative: the whole ray); of a surface: n_up, n_side, cosine to the sun
};
layout(std430, binding = QUESTION_BUFFER) readonly buffer Questions { Question questions[]; };
layout(std430, binding = ANSWER_BUFFER) writeonly buffer Answers { vec4 answers[]; };

layout(location = 0) uniform ivec4 u_size;    // of the tables
layout(location = 1) uniform ivec4 u_mode;    // what is asked; number of questions; 1: all orders; 1: Rayleigh's phase

const int LIGHT = 0, TO_SPACE = 1, SURFACE = 2;

void answer(uint i, vec3 transmittance, vec3 first, vec3 second, float mie_phase) {
    answers[3u * i] = vec4(transmittance, 0.0);
    answers[3u * i + 1u] = vec4(first, 0.0);
    answers[3u * i + 2u] = vec4(second, mie_phase);
}
