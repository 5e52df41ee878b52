// From the counts of visible patches by level to the dispatch that writes their triangles and the draw of these.
#include "generated/bindings.glsl"
layout(local_size_x = 1) in;
layout(std430, binding = COUNT_BUFFER) readonly buffer CountBuffer { uint counts[]; };
layout(std430, binding = PATCH_ARGUMENTS_BUFFER) writeonly buffer ArgumentsBuffer {
    uint arguments[];
};   // a draw of 5, a dispatch of 3

void main() {
    uint quads = 0u;
    for (int k = 0; k < 7; ++k) quads += counts[k] << (2 * k);
    arguments[0] = 6u * quads;
    arguments[1] = 1u;
    arguments[2] = 0u;
    arguments[3] = 0u;
    arguments[4] = 0u;
    arguments[5] = (quads + 63u) / 64u;
    arguments[6] = 1u;
    arguments[7] = 1u;
}
