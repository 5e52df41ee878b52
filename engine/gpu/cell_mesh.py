"""CellMesh: the GPU side of a set of surface cells, shared by every system that draws on the lattice.

Three passes. `vertices` makes the vertices of all selected cells (on a snap of the proxy only), `cull` writes the
indirect draw (when the camera or the cells changed), and `draw` renders the patches. What a vertex is, a system says
with its compute shader; how a pixel looks, with its vertex and fragment shaders. Buffers follow
assets/shaders/common/cells.glsl.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..graph import BufferSpec
from ..surface.selection import CellSet, patch_indices

if TYPE_CHECKING:
    from ..graph import PassIO
    from . import GpuScope

CELL_DTYPE = np.dtype(
    [
        ("face", "i4"),
        ("level", "i4"),
        ("i", "i4"),
        ("j", "i4"),
        ("edge_delta", "u4"),
        ("spacing_m", "f4"),
        ("unused", "f4", 2),
    ]
)
VERTEX_DTYPE = np.dtype([("position_m", "f4", 3), ("dh_m", "f4"), ("normal", "u4"), ("attributes", "u1", 4)])
BOUNDS_BYTES = 32
ARGUMENTS_BYTES = 20  # moderngl's fixed stride: count, instances, first index, base vertex, base instance


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
        indices = patch_indices(quads)
        self.index_count = len(indices)
        self.indices = scope.buffer(indices.astype("<u4").tobytes())
        self.count = 0
        self.selection = 0  # grows with every upload
        self._record = np.zeros(0, CELL_DTYPE)
        self.capacity = capacity
        self._cells = scope.buffer(reserve=capacity * CELL_DTYPE.itemsize, dynamic=True)
        self._vertices: Any = None
        self._bounds: Any = None
        self._visible: Any = None
        self._arguments: Any = None

    def vertex_buffers(self) -> tuple[BufferSpec, BufferSpec]:
        """What the pass that makes the vertices creates: <name>.vertices and <name>.bounds."""
        size = self.capacity * self.vertices_per_cell * VERTEX_DTYPE.itemsize
        return (
            BufferSpec(f"{self.name}.vertices", size, "persistent", "vertices of all selected cells"),
            BufferSpec(f"{self.name}.bounds", self.capacity * BOUNDS_BYTES, "persistent", "a box around each cell"),
        )

    def cull_buffers(self) -> tuple[BufferSpec, BufferSpec]:
        """What the culling pass creates: <name>.visible and <name>.arguments."""
        return (
            BufferSpec(f"{self.name}.visible", self.capacity * 4, "persistent", "indices of the cells that are seen"),
            BufferSpec(f"{self.name}.arguments", ARGUMENTS_BYTES, "persistent", "the indirect draw"),
        )

    def attach_vertices(self, io: PassIO) -> None:
        """Take the plan's vertex and bounds buffers; their content is made anew."""
        self._vertices, self._bounds = (io.buffer(f"{self.name}.{n}") for n in ("vertices", "bounds"))

    def attach_visible(self, io: PassIO) -> None:
        """Take the plan's visible list and arguments."""
        self._visible, self._arguments = (io.buffer(f"{self.name}.{n}") for n in ("visible", "arguments"))

    def upload(self, cells: CellSet) -> bool:
        """Take over a selection: one buffer write. Returns True when the capacity grew: compile the graph again."""
        count = len(cells.face)
        grew = count > self.capacity
        if grew:
            self.capacity = max(count, 2 * self.capacity)
            self.scope.free(self._cells)
            self._cells = self.scope.buffer(reserve=self.capacity * CELL_DTYPE.itemsize, dynamic=True)
        record = np.zeros(count, CELL_DTYPE)
        for name in ("face", "level", "i", "j", "spacing_m"):
            record[name] = getattr(cells, name)
        delta = cells.edge_delta.astype(np.uint32)
        record["edge_delta"] = delta[:, 0] | (delta[:, 1] << 8) | (delta[:, 2] << 16) | (delta[:, 3] << 24)
        self._record = record
        self.count = count
        self.selection += 1
        if count:
            self._cells.write(record.tobytes())
        return grew

    @property
    def record(self) -> NDArray[np.void]:
        """The selected cells as uploaded, (N,) of CELL_DTYPE."""
        return self._record

    def drawn_cells(self) -> int:
        """How many cells the last cull kept. Reads back from the GPU: for overlays, tests and benches."""
        return 0 if self._arguments is None else int(np.frombuffer(self._arguments.read(ARGUMENTS_BYTES), "u4")[1])

    def read_vertices(self) -> NDArray[np.void]:
        """All vertices of the selection, (cells, vertices_per_cell) of VERTEX_DTYPE. Reads back from the GPU."""
        size = self.count * self.vertices_per_cell * VERTEX_DTYPE.itemsize
        data = np.frombuffer(self._vertices.read(size), VERTEX_DTYPE)
        return data.reshape(self.count, self.vertices_per_cell)

    def read_visible(self) -> NDArray[np.uint32]:
        """Indices of the cells that the last cull kept. Reads back from the GPU."""
        return (
            np.frombuffer(self._visible.read(4 * self.drawn_cells()), "u4") if self.drawn_cells() else np.zeros(0, "u4")
        )

    def statistics(self) -> dict[str, int]:
        """Cells selected and drawn, vertices and triangles drawn in the last frame. Reads back from the GPU."""
        drawn = self.drawn_cells()
        return {
            "cells_selected": self.count,
            "cells": drawn,
            "vertices": drawn * self.vertices_per_cell,
            "triangles": drawn * self.index_count // 3,
        }

    def bind_storage(self) -> None:
        """Bind cells, vertices, visible list, arguments and bounds to their storage points."""
        self._cells.bind_to_storage_buffer(0)
        self._vertices.bind_to_storage_buffer(1)
        self._visible.bind_to_storage_buffer(2)
        self._arguments.bind_to_storage_buffer(3)
        self._bounds.bind_to_storage_buffer(5)

    def make_vertices(self, program: Any) -> None:
        """Dispatch the system's vertex compute program, a workgroup a cell."""
        if self.count:
            self._cells.bind_to_storage_buffer(0)
            self._vertices.bind_to_storage_buffer(1)
            self._bounds.bind_to_storage_buffer(5)
            program.run(self.count, 1, 1)

    def cull(self, program: Any, keep_dh_m: tuple[float, float] = (-3.0e38, 3.0e38)) -> None:
        """Write the visible list and the draw arguments with common/cull_cells.comp.

        keep_dh_m: cells that have nothing between these heights above the anchor are dropped.
        """
        self.bind_storage()
        program.set("u_cell_count", self.count)
        program.set("u_index_count", self.index_count)
        program.set("u_keep_dh", keep_dh_m)
        program.run(1, 1, 1)

    def draw(self, vertex_array: Any) -> None:
        """One indirect draw of what cull() kept; vertex_array must hold `indices` as its index buffer."""
        if self.count:
            self.bind_storage()
            vertex_array.render_indirect(self._arguments, moderngl.TRIANGLES, 1)
