// As cover/gbuffer.vert, with the tree's number.
#define main tree_vertex
#include "cover/gbuffer.vert"
#undef main
#include "generated/bindings.glsl"

layout(std430, binding = INSTANCE_BUFFER) readonly buffer NumberBuffer { uint numbers[]; };
flat out uint v_instance;

void main() {
    tree_vertex();
    v_instance = numbers[u_first + gl_InstanceID];
}
