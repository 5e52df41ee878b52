// As props/gbuffer.vert, with the prop's number.
#define main prop_vertex
#include "props/gbuffer.vert"
#undef main
#include "generated/bindings.glsl"

layout(std430, binding = INSTANCE_BUFFER) readonly buffer NumberBuffer { uint numbers[]; };
flat out uint v_instance;

void main() {
    prop_vertex();
    v_instance = numbers[u_first + gl_InstanceID];
}
