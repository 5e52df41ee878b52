// What a probe asks and is answered; systems/atmosphere/probe.py packs and unpacks it.
#include "generated/bindings.glsl"
#include "generated/air_question.glsl"
layout(local_size_x = 16) in;

layout(std430, binding = QUESTION_BUFFER) readonly buffer Questions { AirQuestion questions[]; };
layout(std430, binding = ANSWER_BUFFER) writeonly buffer Answers { AirAnswer answers[]; };

layout(location = 0) uniform ivec3 u_size;        // of the tables: columns, rows, slices
layout(location = 1) uniform int u_count;         // of questions
layout(location = 2) uniform int u_asked;
layout(location = 3) uniform bool u_all_orders;   // of scattering
layout(location = 4) uniform bool u_phase;        // with Rayleigh's phase function

const int LIGHT = 0, TO_SPACE = 1, SURFACE = 2;

void answer(uint i, vec3 transmittance, vec3 first, vec3 second, float mie_phase) {
    answers[i] = AirAnswer(transmittance, first, second, mie_phase);
}
