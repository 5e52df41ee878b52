// Empty lists of sorted tiles.
#include "terrain/wet_lists.glsl"

layout(local_size_x = 8) in;

void main() {
    uint first = gl_LocalInvocationIndex * uint(u_stride);
    sorted[first] = 0u;
    sorted[first + 1u] = 1u;
    sorted[first + 2u] = 1u;
}
