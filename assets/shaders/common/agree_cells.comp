// From what each cell wants to skip to what it may, so that both sides of each edge use the same vertices: `agree` of
// engine/surface/decimation.py, one workgroup for all cells.
#include "generated/bindings.glsl"
#include "common/cells.glsl"

layout(local_size_x = 256) in;
layout(std430, binding = CELL_BUFFER) buffer CellBuffer { Cell cells[]; };
layout(std430, binding = WANTED_BUFFER) coherent buffer WantedBuffer { uint wanted[]; };
// 8 a cell: four rows, four delta | axis << 8
layout(std430, binding = 3) readonly buffer TopologyBuffer { uint beside[]; };
uniform int u_cell_count;

const uint NOBODY = 0xffffffffu;

uint along_axis(int edge) {
    return edge < 2 ? 1u : 0u;
}

void main() {
    uint lane = gl_LocalInvocationID.x, count = uint(u_cell_count);
    // A coarser neighbour may not skip so much that a finer one would have to go beyond its own side.
    for (uint cell = lane; cell < count; cell += 256u) {
        for (int edge = 0; edge < 4; ++edge) {
            uint other = beside[8u * cell + uint(edge)], how = beside[8u * cell + 4u + uint(edge)];
            uint delta = how & 255u;
            if (other != NOBODY && delta > 0u) atomicMin(wanted[2u * other + (how >> 8)], uint(QUADS_LOG2) - delta);
        }
    }
    memoryBarrierBuffer();
    barrier();
    // Each step away from a coarser cell adds a level to what it allows, so its word reaches CELL_MOST cells. A fixed
    // number of turns: llvmpipe loses lanes at a break out of a loop with barriers.
    for (int turn = 0; turn <= CELL_MOST; ++turn) {
        for (uint cell = lane; cell < count; cell += 256u) {
            for (int edge = 0; edge < 4; ++edge) {
                uint other = beside[8u * cell + uint(edge)], how = beside[8u * cell + 4u + uint(edge)];
                uint delta = how & 255u;
                if (other == NOBODY || delta == 0u) continue;
                atomicMin(wanted[2u * cell + along_axis(edge)], delta + wanted[2u * other + (how >> 8)]);
            }
        }
        memoryBarrierBuffer();
        barrier();
    }
    for (uint cell = lane; cell < count; cell += 256u) {
        uint mask = 0u;
        for (int edge = 0; edge < 4; ++edge) {
            uint other = beside[8u * cell + uint(edge)], how = beside[8u * cell + 4u + uint(edge)];
            uint own = wanted[2u * cell + along_axis(edge)];
            uint beyond = other == NOBODY ? 0u : (how & 255u) + wanted[2u * other + (how >> 8)];
            mask |= max(own, beyond) << (8 * edge);
        }
        cells[cell].edge_mask = mask;
        uint skips = wanted[2u * cell] * uint(CELL_MOST + 1) + wanted[2u * cell + 1u];
        cells[cell].variant = 2u * skips + (cells[cell].variant & 1u);   // measure_cells.comp has chosen the diagonals
    }
}
