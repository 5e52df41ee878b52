// As cover/gbuffer.vert, with the tree's number.
#ifndef COVER_SPECIES   // whether the planet has some or not: as its pictures have them
#define COVER_SPECIES
#endif
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
