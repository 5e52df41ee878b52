// The march through shells on an array of questions (systems/clouds/questions.py).
#include "generated/bindings.glsl"
#include "generated/shell_question.glsl"
#include "clouds/uniform_march.glsl"
#if CLOUD_PAPER
#include "clouds/paper_march.glsl"
#endif

layout(local_size_x = 16) in;

struct Answer {
    vec3 radiance, transmittance;
};
layout(std430, binding = QUESTION_BUFFER) readonly buffer Questions { ShellQuestion questions[]; };
layout(std430, binding = ANSWER_BUFFER) writeonly buffer Answers { Answer answers[]; };

layout(location = 0) uniform int u_count;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(u_count)) return;
    ShellQuestion q = questions[i];
    CloudRay ray = CloudRay(ShellRay(q.height_m, q.along_m, q.perigee_m), q.rise_m, q.nu, q.sun_radius_rad, q.multiple);
#if CLOUD_PAPER
    CloudLight light = paper_march(ray, q.length_m);
#else
    CloudLight light = cloud_march(ray, q.length_m);
#endif
    answers[i].radiance = light.radiance;
    answers[i].transmittance = exp(-light.depth);
}
