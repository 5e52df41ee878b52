"""CellMesh: the GPU side of a set of surface cells, shared by every system that draws on the lattice.

Three passes. `vertices` makes the vertices of all selected cells (on a snap of the proxy only), `cull` writes the
indirect draw (when the camera or the cells changed), and `draw` renders the patches. What a vertex is, a system says
with its compute shader; how a pixel looks, with its vertex and fragment shaders. Buffers follow
assets/shaders/common/cells.glsl.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..blocks.bindings import (
    ARGUMENTS_BUFFER,
    BOUNDS_BUFFER,
    CELL_BUFFER,
    RANGE_BUFFER,
    VERTEX_BUFFER,
    VISIBLE_BUFFER,
    WANTED_BUFFER,
)
from ..graph import BufferSpec
from ..surface.decimation import MOST, VARIANTS, Topology, decimated_indices, variant_skips
from ..surface.selection import CellSet
from .cells import BOUNDS_BYTES, CELL_DTYPE, COMMAND_DTYPE

if TYPE_CHECKING:
    from ..graph import PassIO
    from . import Compute, GpuScope, Program, VertexArray

VERTEX_DTYPE = np.dtype([("position_m", "f4", 3), ("dh_m", "f4"), ("normal", "u4"), ("attributes", "u1", 4)])
_TOPOLOGY_BYTES, _WANTED_BYTES = 32, 8
ARGUMENTS_BYTES = COMMAND_DTYPE.itemsize * VARIANTS

Place = tuple[float, ...]


class CellPrograms:
    """What makes and culls cells of quads x quads, shared by all meshes of one kind. vertices: the file of their own
    compute shader."""

    def __init__(self, scope: GpuScope, quads: int, vertices: str) -> None:
        self.quads = quads
        self.defines: dict[str, int] = {"QUADS_LOG2": quads.bit_length() - 1}
        self.vertices = scope.compute(vertices, defines=self.defines)
        shared = "common/measure_cells.comp", "common/agree_cells.comp", "common/cull_cells.comp"
        self.measure, self.agree, self.cull = (scope.compute(file, defines=self.defines) for file in shared)


class CellMesh:
    """Cells, their vertices, what of them is seen, and the three passes that make and draw them.

    scope: owner of the cell and index buffers; the rest belongs to the frame graph (`buffer_specs`) and is attached
    when a plan is bound. quads: cells are quads x quads (8, 16 or 32). capacity: cells to begin with; it doubles when
    a selection needs more, and `upload` then says that the graph has to be compiled again.
    """

    def __init__(self, scope: GpuScope, name: str, quads: int, capacity: int = 512) -> None:
        self.scope = scope
        self.name = name
        self.quads = quads
        self.vertices_per_cell = (quads + 1) ** 2
        self.part_step = max(scope.caps.storage_offset_bytes // _WANTED_BYTES, 1)
        """Parts begin at multiples of so many cells. All that a cell has comes in multiples of 8 bytes."""
        indices, self.index_ranges = decimated_indices(quads)
        self.indices = scope.buffer(indices.astype("<u4").tobytes())
        self._ranges = scope.buffer(self.index_ranges.astype("<u4").tobytes())
        self.count = 0
        self.selection = 0  # grows with every upload
        self.capacity = capacity
        self._reserve()
        self._buffers: dict[str, moderngl.Buffer] = {}
        """Those of the graph, by the last part of their names."""
        self._arrays: dict[Program, tuple[VertexArray, moderngl.Buffer]] = {}

    def vertex_buffers(self) -> tuple[BufferSpec, ...]:
        """What the pass that makes the vertices creates: <name>.vertices, <name>.bounds and <name>.wanted."""
        size = self.capacity * self.vertices_per_cell * VERTEX_DTYPE.itemsize
        return (
            BufferSpec(f"{self.name}.vertices", size, "persistent", "vertices of all selected cells"),
            BufferSpec(f"{self.name}.bounds", self.capacity * BOUNDS_BYTES, "persistent", "a box around each cell"),
            BufferSpec(f"{self.name}.wanted", self.capacity * _WANTED_BYTES, "persistent", "what each cell would skip"),
        )

    def cull_buffers(self) -> tuple[BufferSpec, BufferSpec]:
        """What the culling pass creates: <name>.visible and <name>.arguments."""
        return (
            BufferSpec(
                f"{self.name}.visible", VARIANTS * self.capacity * 4, "persistent", "cells that are seen, by variant"
            ),
            BufferSpec(f"{self.name}.arguments", ARGUMENTS_BYTES, "persistent", "the indirect draws"),
        )

    def attach_vertices(self, io: PassIO) -> bool:
        """Take the plan's buffers of vertex_buffers(). True where they are others than before: empty ones."""
        return self._attach(io, "vertices", "bounds", "wanted")

    def attach_visible(self, io: PassIO) -> bool:
        """Take the plan's visible list and arguments. True where they are others than before: empty ones."""
        return self._attach(io, "visible", "arguments")

    def _attach(self, io: PassIO, *names: str) -> bool:
        before = [self._buffers.get(n) for n in names]
        self._buffers |= {n: io.buffer(f"{self.name}.{n}") for n in names}
        return before != [self._buffers[n] for n in names]

    def upload(self, cells: CellSet, beside: Topology) -> bool:
        """Take over a selection: two buffer writes. Returns True when the capacity grew: compile the graph again."""
        count = len(cells.face)
        grew = count > self.capacity
        if grew:
            # Twice as many, but never more than a buffer may hold while those that are wanted fit.
            most = self.scope.caps.max_storage_block_bytes // (self.vertices_per_cell * VERTEX_DTYPE.itemsize)
            self._make_room(max(count, min(2 * self.capacity, most)))
        record = np.zeros(count, CELL_DTYPE)
        for name in ("face", "level", "i", "j", "spacing_m", "distance_m"):
            record[name] = getattr(cells, name)
        self.count = count
        self.selection += 1
        if count:
            self._cells.write(record.tobytes())
            self.topology.write(beside.packed().tobytes())
        return grew

    def reserve(self, capacity: int) -> bool:
        """Make room for so many cells and no more, before there are any that are wanted: those that are there are lost.
        Returns True when the capacity grew."""
        if capacity <= self.capacity:
            return False
        self.count = 0
        self._make_room(capacity)
        return True

    def _make_room(self, capacity: int) -> None:
        self.capacity = capacity
        self.scope.free(self._cells)
        self.scope.free(self.topology)
        self._reserve()

    def take(self, other: CellMesh) -> bool:
        """Take over another mesh with its vertices, on the GPU, and make as much room as it has. Returns True when the
        capacity grew: compile the graph again, and then `take_vertices`, while the other has them."""
        grew = other.capacity > self.capacity
        if grew:
            self._make_room(other.capacity)
        self.count = other.count
        self.selection += 1
        if self.count:
            copy = self.scope.ctx.copy_buffer
            copy(self._cells, other._cells, self.count * CELL_DTYPE.itemsize)
            copy(self.topology, other.topology, self.count * _TOPOLOGY_BYTES)
            if not grew:
                self.take_vertices(other)
        return grew

    def take_vertices(self, other: CellMesh) -> None:
        """The vertices of `other`, which has the same cells."""
        copy = self.scope.ctx.copy_buffer
        size = self.vertices_per_cell * VERTEX_DTYPE.itemsize
        for name, each in (("vertices", size), ("bounds", BOUNDS_BYTES), ("wanted", _WANTED_BYTES)):
            copy(self._buffers[name], other._buffers[name], self.count * each)

    def _reserve(self) -> None:
        self._cells = self.scope.buffer(reserve=self.capacity * CELL_DTYPE.itemsize, dynamic=True)
        self.topology = self.scope.buffer(reserve=self.capacity * _TOPOLOGY_BYTES, dynamic=True)

    def copy_to(self, cells: moderngl.Buffer, vertices: moderngl.Buffer) -> None:
        """Copy the cells with what was agreed on, and their vertices, to other buffers on the GPU."""
        ctx = self.scope.ctx
        ctx.copy_buffer(cells, self._cells, self.count * CELL_DTYPE.itemsize)
        size = self.count * self.vertices_per_cell * VERTEX_DTYPE.itemsize
        ctx.copy_buffer(vertices, self._buffers["vertices"], size)

    def bind_made(self, cells: int = CELL_BUFFER, vertices: int = VERTEX_BUFFER) -> None:
        """Bind cells and vertices to these storage points."""
        self._cells.bind_to_storage_buffer(cells)
        self._buffers["vertices"].bind_to_storage_buffer(vertices)

    def bind_part(self, first: int) -> None:
        """Bind cells, vertices and boxes from a cell on (a multiple of part_step) to their storage points."""
        self._cells.bind_to_storage_buffer(CELL_BUFFER, offset=first * CELL_DTYPE.itemsize)
        size = self.vertices_per_cell * VERTEX_DTYPE.itemsize
        self._buffers["vertices"].bind_to_storage_buffer(VERTEX_BUFFER, offset=first * size)
        self._buffers["bounds"].bind_to_storage_buffer(BOUNDS_BUFFER, offset=first * BOUNDS_BYTES)

    def bind_bounds(self, bounds: int) -> None:
        """Bind the boxes of all cells."""
        self._buffers["bounds"].bind_to_storage_buffer(bounds)

    def bind_wanted(self) -> None:
        """Bind what each cell would skip."""
        self._buffers["wanted"].bind_to_storage_buffer(WANTED_BUFFER)

    def read_cells(self) -> NDArray[np.void]:
        """The selected cells with the masks and variants that were agreed on, (N,) of CELL_DTYPE. Reads back."""
        return np.frombuffer(self._cells.read(self.count * CELL_DTYPE.itemsize), CELL_DTYPE)

    def drawn_by_variant(self) -> NDArray[np.uint32]:
        """Cells that the last cull kept, by variant (VARIANTS,). Reads back from the GPU."""
        if "arguments" not in self._buffers:
            return np.zeros(VARIANTS, np.uint32)
        return np.frombuffer(self._buffers["arguments"].read(ARGUMENTS_BYTES), "u4").reshape(VARIANTS, 5)[:, 1]

    def read_vertices(self) -> NDArray[np.void]:
        """All vertices of the selection, (cells, vertices_per_cell) of VERTEX_DTYPE. Reads back from the GPU."""
        size = self.count * self.vertices_per_cell * VERTEX_DTYPE.itemsize
        data = np.frombuffer(self._buffers["vertices"].read(size), VERTEX_DTYPE)
        return data.reshape(self.count, self.vertices_per_cell)

    def read_visible(self) -> NDArray[np.uint32]:
        """Indices of the cells that the last cull kept. Reads back from the GPU."""
        counts = self.drawn_by_variant()
        found = np.frombuffer(self._buffers["visible"].read(VARIANTS * self.capacity * 4), "u4")
        lists = found.reshape(VARIANTS, self.capacity)
        return np.concatenate([row[:n] for row, n in zip(lists, counts, strict=True)])

    def statistics(self) -> dict[str, int]:
        """Cells selected and drawn, vertices and triangles drawn in the last frame. Reads back from the GPU."""
        drawn = self.drawn_by_variant().astype(int)
        across, along = (self.quads // np.minimum(1 << s, self.quads) + 1 for s in variant_skips(np.arange(VARIANTS)))
        vertices = across * along
        return {
            "cells_selected": self.count,
            "cells": int(drawn.sum()),
            "vertices": int(drawn @ vertices),
            "triangles": int(drawn @ self.index_ranges[:, 1]) // 3,
        }

    def bind_storage(self) -> None:
        """Bind cells, vertices, visible list, arguments and bounds to their storage points."""
        self._cells.bind_to_storage_buffer(CELL_BUFFER)
        self._buffers["vertices"].bind_to_storage_buffer(VERTEX_BUFFER)
        self._buffers["visible"].bind_to_storage_buffer(VISIBLE_BUFFER)
        self._buffers["arguments"].bind_to_storage_buffer(ARGUMENTS_BUFFER)
        self._buffers["bounds"].bind_to_storage_buffer(BOUNDS_BUFFER)

    def make_part(
        self, programs: CellPrograms, eye_m: Place, edge_rad: float, chord_m: float, most: int, first: int, count: int
    ) -> None:
        """The vertices of `count` cells from `first` on, and what they would skip; `agree` once all have theirs.

        eye_m: the proxy from the anchor. edge_rad: the wanted length of an edge as an angle. chord_m: square of the
        length of an edge per distance at which the sphere bulges visibly above it. most: 0..MOST, how many powers of
        two a cell may skip. first: a multiple of part_step.
        """
        self.bind_part(first)
        programs.vertices.run(count, 1, 1)
        self.scope.barrier()
        self._buffers["wanted"].bind_to_storage_buffer(WANTED_BUFFER, offset=first * _WANTED_BYTES)
        measure = programs.measure
        measure.set("u_eye", eye_m)
        measure.set("u_angle", edge_rad)
        measure.set("u_chord", chord_m)
        measure.set("u_most", min(most, MOST, self.quads.bit_length() - 1))
        measure.run(count, 1, 1)
        self.scope.barrier()

    def agree(self, agree: Compute) -> None:
        """From what each cell wants to skip to what it may, with common/agree_cells.comp."""
        self._cells.bind_to_storage_buffer(CELL_BUFFER)
        self._buffers["wanted"].bind_to_storage_buffer(WANTED_BUFFER)
        self.topology.bind_to_storage_buffer(3)
        agree.set("u_cell_count", self.count)
        agree.run(1, 1, 1)
        self.scope.barrier()

    def cull(self, program: Compute, keep_dh_m: tuple[float, float] = (-3.0e38, 3.0e38), hides: bool = True) -> None:
        """Write the visible list and the draw arguments with common/cull_cells.comp.

        keep_dh_m: cells that have nothing between these heights above the anchor are dropped. hides: near cells hide
        far ones, below the horizon or the skyline; not so for a surface that is seen from behind.
        """
        self.bind_storage()
        program.set("u_cell_count", self.count)
        self._ranges.bind_to_storage_buffer(RANGE_BUFFER)
        program.set("u_capacity", self.capacity)
        program.set("u_keep_dh", keep_dh_m)
        program.set("u_hides", int(hides))
        program.run(1, 1, 1)

    def vertex_array(self, program: Program) -> VertexArray:
        """The patches for a program that has `in uint in_cell`: one instance a visible cell. Ask for it in a pass's
        bind; passes that draw with one program share it."""
        visible = self._buffers["visible"]
        made, of = self._arrays.get(program, (None, None))
        if made is not None and of is visible:
            return made
        if made is not None:
            self.scope.free(made)
        made = self.scope.vertex_array(
            program, content=[(visible, "1u/i", "in_cell")], index=self.indices, index_size=4
        )
        self._arrays[program] = made, visible
        return made

    def draw(self, vertex_array: VertexArray, vertices: moderngl.Buffer | None = None) -> None:
        """Indirect draws of what cull() kept, one a variant. vertices: a buffer to take in place of <name>.vertices."""
        if self.count:
            self._cells.bind_to_storage_buffer(CELL_BUFFER)
            (self._buffers["vertices"] if vertices is None else vertices).bind_to_storage_buffer(VERTEX_BUFFER)
            vertex_array.render_indirect(self._buffers["arguments"], moderngl.TRIANGLES, VARIANTS)
