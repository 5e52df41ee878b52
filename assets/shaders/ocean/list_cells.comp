// The visible cells of all index lists in one list, and the dispatch over it: a work group a cell.
#include "generated/bindings.glsl"
#include "common/cells.glsl"

layout(local_size_x = 32) in;
layout(std430, binding = VISIBLE_BUFFER) readonly buffer VisibleBuffer { uint visible[]; };
layout(std430, binding = ARGUMENTS_BUFFER) readonly buffer ArgumentsBuffer { uint arguments[]; };
// four words of dispatch, then cells
layout(std430, binding = MOVED_CELLS_BUFFER) writeonly buffer ListBuffer { uint list[]; };

void main() {
    uint lane = gl_LocalInvocationID.x, first = 4u;
    for (uint k = 0u; k < uint(CELL_LISTS); ++k) {
        uint count = arguments[5u * k + 1u], from = arguments[5u * k + 4u];
        for (uint i = lane; i < count; i += 32u) list[first + i] = visible[from + i];
        first += count;
    }
    if (lane < 4u) list[lane] = lane == 0u ? first - 4u : 1u;
}
