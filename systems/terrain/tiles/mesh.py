"""TileMesh: one view's drawn tiles: assembled by slot, culled, and drawn with one indirect draw."""

from __future__ import annotations

from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ....engine.blocks.bindings import (
    ARGUMENTS_BUFFER,
    BOUNDS_BUFFER,
    CELL_BUFFER,
    RANGE_BUFFER,
    TILE_LIST_BUFFER,
    TILE_ROW_BUFFER,
    TILE_SLOT_BUFFER,
    VERTEX_BUFFER,
    VISIBLE_BUFFER,
)
from ....engine.gpu import Compute, GpuScope, Program, VertexArray
from ....engine.gpu.cell_mesh import VERTEX_DTYPE
from ....engine.gpu.cells import BOUNDS_BYTES, COMMAND_DTYPE, TILE_CELL_DTYPE
from ....engine.graph import BufferSpec, PassIO
from ....engine.surface.forest import Selection
from .shape import TileShape
from .slots import ROW_DTYPE

__all__ = ["TileMesh"]

Ints = NDArray[np.int64]


class TileMesh:
    """The tiles of one view.

    take() names the tiles of a selection; assemble() makes the vertices of those whose edges, morphs or anchor differ
    from what lies in their slots; cull() lists what can be seen. gpu: owner of the small buffers; the large ones belong
    to the frame graph.
    """

    def __init__(self, gpu: GpuScope, shape: TileShape, slots: int) -> None:
        self.gpu, self.shape, self.slots = gpu, shape, slots
        self._cells = gpu.buffer(reserve=slots * TILE_CELL_DTYPE.itemsize, dynamic=True)
        self._rows = gpu.buffer(reserve=slots * ROW_DTYPE.itemsize, dynamic=True)
        self._list = gpu.buffer(reserve=slots * 4, dynamic=True)
        self._range = gpu.buffer(np.array([0, shape.indices.size], "<u4"))
        self._indices = gpu.buffer(shape.indices.astype("<u4"))
        self.count = 0
        self.cells: NDArray[np.void] = np.zeros(0, TILE_CELL_DTYPE)
        self.rows: NDArray[np.void] = np.zeros(0, ROW_DTYPE)
        self.keys: Ints = np.zeros(0, np.int64)
        self._drawn = np.zeros(slots, ROW_DTYPE)  # what the vertices in each slot were made for
        self._stamps = np.full(slots, -1, np.int64)  # and around which anchor
        self._anchor = 0
        self._stale: Ints = np.zeros(0, np.int64)  # rows to assemble
        self._vertices: Any = None
        self._bounds: Any = None
        self._visible: Any = None
        self._arguments: Any = None
        self._morphs: Any = None
        self._arrays: dict[Program, tuple[VertexArray, moderngl.Buffer]] = {}

    # -- buffers of the graph ----------------------------------------------------------------------------------------

    def vertex_buffers(self) -> tuple[BufferSpec, ...]:
        """What the assembling pass creates."""
        size = self.slots * self.shape.vertices * VERTEX_DTYPE.itemsize
        return (
            BufferSpec("terrain.vertices", size, "persistent", "vertices of tiles, by slot"),
            BufferSpec("terrain.bounds", self.slots * BOUNDS_BYTES, "persistent", "a box around each tile, by slot"),
        )

    def cull_buffers(self) -> tuple[BufferSpec, ...]:
        """What the culling pass creates."""
        return (
            BufferSpec("terrain.visible", self.slots * 4, "persistent", "slots of the tiles that are seen"),
            BufferSpec("terrain.arguments", COMMAND_DTYPE.itemsize, "persistent", "the indirect draw"),
        )

    def attach_vertices(self, io: PassIO) -> None:
        """Take the plan's buffers; where they are new all is to be assembled again."""
        before = self._vertices, self._bounds
        self._vertices, self._bounds = io.buffer("terrain.vertices"), io.buffer("terrain.bounds")
        if before != (self._vertices, self._bounds):
            self._stamps[:] = -1
            self._stale = np.arange(self.count)

    def attach_visible(self, io: PassIO) -> bool:
        """Take the plan's list and arguments; whether they are new."""
        before = self._visible, self._arguments
        self._visible, self._arguments = io.buffer("terrain.visible"), io.buffer("terrain.arguments")
        return before != (self._visible, self._arguments)

    # -- selection ---------------------------------------------------------------------------------------------------

    @property
    def stale(self) -> bool:
        """Whether there is anything to assemble."""
        return len(self._stale) > 0

    def take(self, selection: Selection, slots: Ints, radius_m: float, morphs: bool = True) -> None:
        """Draw these tiles from now on; slots (N,) of theirs. morphs: as the selection has them, or all at rest."""
        shape, count = self.shape, len(selection.keys)
        edges = selection.edge_skip.shape[1]
        rows = np.zeros(count, ROW_DTYPE)
        rows["name"], rows["slot"] = shape.names(selection.keys), slots
        shifts = (8 * np.arange(edges)).astype(np.uint32)
        # Of an edge at least its ends remain.
        skip = np.minimum(selection.edge_skip, shape.segments.bit_length() - 1)
        rows["edge_skip"] = (skip.astype(np.uint32) << shifts).sum(axis=1)
        if morphs:
            rows["morph"], rows["edge_morph"][:, :edges] = selection.morph, selection.edge_morph
        rows["spacing_m"] = radius_m * shape.scheme.spacing_rad(shape.scheme.level(selection.keys), shape.segments)
        cells = np.zeros(count, TILE_CELL_DTYPE)
        cells[["face", "level", "i", "j"]] = rows["name"]
        cells["slot"], cells["spacing_m"] = rows["slot"], rows["spacing_m"]
        cells["distance_m"] = selection.distance_m
        self.count, self.rows, self.cells, self.keys = count, rows, cells, selection.keys
        if count:
            self._rows.write(rows.tobytes())
            self._cells.write(cells.tobytes())
        self._compare()

    def around(self, anchor: int) -> None:
        """Vertices are to be relative to this anchor (a number that stands for it)."""
        if anchor != self._anchor:
            self._anchor = anchor
            self._compare()

    def forget(self, slots: Ints) -> None:
        """Other heights lie in these slots now."""
        self._stamps[slots] = -1
        self._compare()

    def _compare(self) -> None:
        slots = self.rows["slot"]
        same = (self._stamps[slots] == self._anchor) & (self._drawn[slots] == self.rows)
        self._stale = np.flatnonzero(~same)

    # -- passes ------------------------------------------------------------------------------------------------------

    def assemble(self, program: Compute, heights: moderngl.Buffer, anchor_steps: int, step_m: float) -> int:
        """Make the vertices of what is stale; returns how many tiles that were. heights: the slots' buffer."""
        stale = self._stale
        if not len(stale):
            return 0
        self._list.write(stale.astype("<u4").tobytes())
        buffers = (
            (TILE_ROW_BUFFER, self._rows),
            (VERTEX_BUFFER, self._vertices),
            (TILE_SLOT_BUFFER, heights),
            (TILE_LIST_BUFFER, self._list),
            (BOUNDS_BUFFER, self._bounds),
        )
        for place, buffer in buffers:
            buffer.bind_to_storage_buffer(place)
        program.set("u_anchor_height", anchor_steps)
        program.set("u_step_m", step_m)
        program.run(len(stale), 1, 1)
        slots = self.rows["slot"][stale]
        self._stamps[slots], self._drawn[slots] = self._anchor, self.rows[stale]
        self._stale = np.zeros(0, np.int64)
        return len(stale)

    def cull(self, program: Compute, keep_dh_m: tuple[float, float]) -> None:
        """Write the visible list and the draw with common/cull_cells.comp."""
        buffers = (
            (CELL_BUFFER, self._cells),
            (VERTEX_BUFFER, self._vertices),
            (VISIBLE_BUFFER, self._visible),
            (ARGUMENTS_BUFFER, self._arguments),
            (BOUNDS_BUFFER, self._bounds),
            (RANGE_BUFFER, self._range),
        )
        for place, buffer in buffers:
            buffer.bind_to_storage_buffer(place)
        program.set("u_cell_count", self.count)
        program.set("u_capacity", self.slots)
        program.set("u_keep_dh", keep_dh_m)
        program.set("u_hides", 1)
        program.run(1, 1, 1)

    def vertex_array(self, program: Program) -> VertexArray:
        """The tiles for a program with `in uint in_slot`; passes that draw with one program share it."""
        made, of = self._arrays.get(program, (None, None))
        if made is not None and of is self._visible:
            return made
        if made is not None:
            self.gpu.free(made)
        made = self.gpu.vertex_array(
            program, content=[(self._visible, "1u/i", "in_slot")], index=self._indices, index_size=4
        )
        self._arrays[program] = made, self._visible
        return made

    def draw(self, vertex_array: VertexArray) -> None:
        """One indirect draw of what cull() kept."""
        if self.count:
            self._vertices.bind_to_storage_buffer(VERTEX_BUFFER)
            vertex_array.render_indirect(self._arguments, moderngl.TRIANGLES, 1)

    def bind_morphs(self) -> None:
        """Bind the morph of each slot, for the view of it."""
        morphs = np.zeros(self.slots, "<f4")
        morphs[self.rows["slot"]] = self.rows["morph"]
        if self._morphs is None:
            self._morphs = self.gpu.buffer(reserve=morphs.nbytes, dynamic=True)
        self._morphs.write(morphs.tobytes())
        self._morphs.bind_to_storage_buffer(6)

    # -- reading back ------------------------------------------------------------------------------------------------

    def statistics(self) -> dict[str, int]:
        """Tiles selected and drawn, vertices and triangles drawn in the last frame. Reads back from the GPU."""
        drawn = (
            0 if self._arguments is None else int(np.frombuffer(self._arguments.read(), COMMAND_DTYPE)["instances"][0])
        )
        return {
            "cells_selected": self.count,
            "cells": drawn,
            "vertices": drawn * self.shape.vertices,
            "triangles": drawn * self.shape.indices.size // 3,
        }

    def read_vertices(self) -> NDArray[np.void]:
        """All vertices of the selection as assembled, (tiles, vertices) of VERTEX_DTYPE. Reads back from the GPU."""
        data = np.frombuffer(self._vertices.read(), VERTEX_DTYPE).reshape(self.slots, self.shape.vertices)
        return data[self.rows["slot"]]

    def read_visible(self) -> Ints:
        """Rows of the selection that the last cull kept. Reads back from the GPU."""
        drawn = self.statistics()["cells"]
        slots = np.frombuffer(self._visible.read(4 * drawn), "u4") if drawn else np.zeros(0, "u4")
        return np.flatnonzero(np.isin(self.rows["slot"], slots))
