// The march on an array of questions; systems/clouds/probe.py packs and unpacks it.
#include "generated/bindings.glsl"
#include "clouds/uniform_march.glsl"
#if CLOUD_PAPER
#include "clouds/paper_march.glsl"
#endif

layout(local_size_x = 16) in;

struct Question {
    vec4 ray;    // of the start: h, (R + h) mu, perigee, coordinate along the sun's direction
    vec4 more;   // cosine to the sun, distance to march, the sun's angular radius (0: a point), 1: all orders
};
layout(std430, binding = QUESTION_BUFFER) readonly buffer Questions { Question questions[]; };
layout(std430, binding = ANSWER_BUFFER) writeonly buffer Answers { vec4 answers[]; };

layout(location = 0) uniform int u_count;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(u_count)) return;
    Question q = questions[i];
    CloudRay ray = CloudRay(ShellRay(q.ray.x, q.ray.y, q.ray.z), q.ray.w, q.more.x, q.more.z, q.more.w);
#if CLOUD_PAPER
    CloudLight light = paper_march(ray, q.more.y);
#else
    CloudLight light = cloud_march(ray, q.more.y);
#endif
    answers[2u * i] = vec4(light.radiance, 0.0);
    answers[2u * i + 1u] = vec4(exp(-light.depth), 0.0);
}
