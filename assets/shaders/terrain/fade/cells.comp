// What each cell of the overlay skips: not more than the old and the new selection do there, so that it has the
// vertices of both.
#include "generated/bindings.glsl"
#include "terrain/fade/locate.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = CELL_BUFFER) buffer CellBuffer { Cell cells[]; };
layout(std430, binding = WANTED_BUFFER) writeonly buffer WantedBuffer { uint wanted[]; };
layout(std430, binding = FADE_OLD_BUFFER) readonly buffer OldBuffer { Cell old_cells[]; };
layout(std430, binding = FADE_BUFFER) buffer FadeBuffer { FadeCell fade[]; };
layout(std430, binding = FADE_NEW_BUFFER) readonly buffer NewBuffer { Cell new_cells[]; };
uniform int u_cell_count;

void main() {
    int index = int(gl_GlobalInvocationID.x);
    if (index >= u_cell_count) return;
    FadeCell known = fade[index];
    Cell after = new_cells[known.new_row], before = after;
    if (known.old_row >= 0) before = old_cells[known.old_row];
    int level = cells[index].level;
    uint halves = uint(CELL_MOST + 1);
    ivec2 skip_after = ivec2(after.variant >> 1) / ivec2(halves, 1) % int(halves) + (level - after.level);
    ivec2 skip_before = ivec2(before.variant >> 1) / ivec2(halves, 1) % int(halves) + (level - before.level);
    ivec2 skip = clamp(min(skip_after, skip_before), ivec2(0), ivec2(min(CELL_MOST, QUADS_LOG2)));
    wanted[2 * index] = uint(skip.x);
    wanted[2 * index + 1] = uint(skip.y);
    cells[index].variant = after.variant & 1u;
    fade[index].old_code = uint(before.level) | before.variant << 8;
    fade[index].new_code = uint(after.level) | after.variant << 8;
    fade[index].old_mask = before.edge_mask;
    fade[index].new_mask = after.edge_mask;
}
