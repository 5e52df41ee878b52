// From the counts of visible patches by level to the draw of their triangles, and to the dispatches that write these
// and that displace the vertices.
#include "generated/bindings.glsl"
layout(local_size_x = 1) in;
layout(std430, binding = COUNT_BUFFER) readonly buffer CountBuffer { uint counts[]; };
// a draw of 5, two dispatches of 3
layout(std430, binding = PATCH_ARGUMENTS_BUFFER) writeonly buffer ArgumentsBuffer { uint arguments[]; };

void main() {
    uint quads = 0u, vertices = 0u;
    for (int k = 0; k < 7; ++k) {
        uint side = (1u << k) + 1u;
        quads += counts[k] << (2 * k);
        vertices += counts[k] * side * side;
    }
    arguments[0] = 6u * quads;
    arguments[1] = 1u;
    arguments[2] = 0u;
    arguments[3] = 0u;
    arguments[4] = 0u;
    arguments[5] = (quads + 63u) / 64u;
    arguments[6] = 1u;
    arguments[7] = 1u;
    arguments[8] = (vertices + uint(32 * SEA_VERTICES) - 1u) / uint(32 * SEA_VERTICES);
    arguments[9] = 1u;
    arguments[10] = 1u;
}
