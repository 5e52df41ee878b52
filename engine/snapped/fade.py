"""What a surface may do at a snap: it leads from the old selection's surface to the new one's, instead of jumping.

Vertices that both have don't move. Where one selection has more vertices than the other, or its triangles lie another
way, the two surfaces differ by a fraction of a pixel; for at most `longest_s` the overlay of both selections is
drawn (engine/surface/overlay.py), whose vertices go from one surface to the other. Then the new selection is drawn as
it is: the same bits as if it had been there all along, and no cost.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from moderngl import Buffer
from numpy.typing import NDArray

from ..blocks.bindings import FADE_BUFFER, FADE_NEW_BUFFER, FADE_OLD_BUFFER, FADE_START_BUFFER
from ..blocks.layout import StructLayout, UInt, Vec3
from ..gpu import GpuScope
from ..gpu.cell_mesh import VERTEX_DTYPE, CellMesh, CellPrograms
from ..gpu.cells import CELL_DTYPE
from ..graph import BufferSpec, PassIO
from ..made_shaders import made_shader
from ..surface.decimation import topology
from ..surface.overlay import Overlay, held_edges, overlay
from .choice import CellChoice

__all__ = ["FadePrograms", "SnapFade"]

_SHARE_OF_INTERVAL = 0.9
"""When snaps follow one another quickly, each fade is over before the next snap is due."""


@dataclass
class FadeCell:
    """What the overlay knows of each of its cells."""

    old_row: Annotated[int, "cell of the old selection that contains it; -1: none"]
    new_row: Annotated[int, "and of the new one"]
    changed: Annotated[UInt, "1: its surface moves"]
    old_code: Annotated[UInt, "level | variant << 8 of the old selection's cell"]
    new_code: UInt
    old_mask: Annotated[UInt, "its edge_mask"]
    new_mask: UInt
    held: Annotated[UInt, "edges whose vertices may not move, a bit each: no old surface beyond"]


@dataclass
class FadeStart:
    """Where a vertex starts, from the new anchor."""

    position_m: Vec3
    normal: Annotated[UInt, "octahedral, 2 x snorm16, planet axes"]


_CELL, _START = StructLayout(FadeCell, "std430"), StructLayout(FadeStart, "std430")
made_shader("generated/fade.glsl", lambda: _CELL.glsl + _START.glsl)


class FadePrograms:
    """What makes the overlay, shared by all views: files of two compute shaders. longest_s: of a fade."""

    def __init__(self, gpu: GpuScope, cells: str, vertices: str, programs: CellPrograms, longest_s: float) -> None:
        self.cells, self.vertices = (gpu.compute(file, defines=programs.defines) for file in (cells, vertices))
        self.agree, self.longest_s = programs.agree, longest_s


class SnapFade:
    """One view's fade. mesh: what is drawn when nothing fades."""

    def __init__(self, gpu: GpuScope, mesh: CellMesh, programs: FadePrograms) -> None:
        self._gpu, self._final, self._programs = gpu, mesh, programs
        self.mesh = CellMesh(gpu, f"{mesh.name}_fade", mesh.quads)
        self._known = gpu.buffer(reserve=self.mesh.capacity * _CELL.size, dynamic=True)
        self._starts: Buffer
        self._old: tuple[Buffer, Buffer] | None = None
        self._kept: CellChoice | None = None
        self._shift_m: tuple[float, ...] = (0.0, 0.0, 0.0)
        self._rise_m = 0.0
        self._pending = False  # the overlay was uploaded, its vertices are not made
        self.laying = False  # the overlay of a snap that is being prepared was uploaded
        self._laid = -1  # its cells with vertices; -1: cells have not agreed
        self._new = mesh  # has the vertices of the new selection
        self._age_s = np.inf
        self._duration_s = 0.0
        self._since_snap_s = np.inf

    @property
    def running(self) -> bool:
        """Whether the overlay is drawn."""
        return self._age_s < self._duration_s

    @property
    def laid(self) -> bool:
        """Whether the overlay that `lay` began is complete."""
        return self.laying and self._laid >= self.mesh.count

    @property
    def part(self) -> float:
        """How far the surface has come, 0..1."""
        return float(np.clip(self._age_s / self._duration_s, 0.0, 1.0)) if self._duration_s > 0.0 else 1.0

    def advance(self, dt_s: float) -> None:
        """Time goes on, once a frame."""
        self._age_s += dt_s
        self._since_snap_s += dt_s

    def stop(self) -> None:
        """The new selection, at once."""
        self._age_s, self._pending, self._kept, self.laying = np.inf, False, None, False

    def keep(self, choice: CellChoice) -> None:
        """Before another selection is uploaded to the final mesh: keep its cells and vertices as the old ones."""
        final = self._final
        wanted = (final.count * CELL_DTYPE.itemsize, final.count * final.vertices_per_cell * VERTEX_DTYPE.itemsize)
        if self._old is None or any(b.size < w for b, w in zip(self._old, wanted, strict=True)):
            for buffer in self._old or ():
                self._gpu.free(buffer)
            first, second = (self._gpu.buffer(reserve=w * 3 // 2) for w in wanted)
            self._old = (first, second)
        final.copy_to(*self._old)
        self._kept = choice

    def begin(self, choice: CellChoice) -> bool:
        """After the new selection was uploaded. Returns True when buffers of the graph grew."""
        grew = self._overlay(choice, self._final)
        self.start()
        self._pending = True
        return grew

    def start(self) -> None:
        """From now on the overlay is drawn; it has been laid."""
        self._duration_s = min(self._programs.longest_s, _SHARE_OF_INTERVAL * self._since_snap_s)
        self._age_s = self._since_snap_s = 0.0
        self.laying = self._pending = False

    def lay(self, old: CellChoice, new: CellChoice, made: CellMesh) -> bool:
        """Begin to prepare the overlay of what is drawn and of a selection whose vertices are in another mesh; not
        while it is running. Returns True when buffers of the graph grew."""
        self.keep(old)
        grew = self._overlay(new, made)
        self.laying, self._laid = True, -1
        return grew

    def reserve(self, room: int) -> bool:
        """Room for the next fade, unless one is there. Returns True when buffers of the graph grew."""
        return not (self.running or self.laying or self.pending) and self.mesh.reserve(room)

    def lay_part(self, count: int) -> bool:
        """In a pass: so many cells of the overlay; True once all have their vertices."""
        if self._laid < 0:
            self._agree()
            self._laid = 0
        self._make(self._laid, min(count, self.mesh.count - self._laid))
        self._laid += count
        return self._laid >= self.mesh.count

    def _overlay(self, choice: CellChoice, made: CellMesh) -> bool:
        """Upload the overlay of the kept selection and a new one, whose vertices `made` has."""
        kept = self._kept
        assert kept is not None
        self._new = made
        grew = self._upload(overlay(kept.cells, choice.cells))
        self._shift_m = tuple((kept.proxy.anchor_m - choice.proxy.anchor_m).tolist())
        self._rise_m = kept.proxy.anchor_height_m - choice.proxy.anchor_height_m
        return grew

    def _upload(self, both: Overlay) -> bool:
        beside = topology(both.cells)
        grew = self.mesh.upload(both.cells, beside)
        known = np.zeros(len(both.cells), _CELL.dtype)
        known["old_row"], known["new_row"] = both.old_row, both.new_row
        known["held"] = held_edges(both.cells, beside.beside, both.old_row < 0) @ (1 << np.arange(4))
        if self._known.size < known.nbytes:
            self._gpu.free(self._known)
            self._known = self._gpu.buffer(reserve=self.mesh.capacity * _CELL.size, dynamic=True)
        self._known.write(known.tobytes())
        return grew

    def buffers(self) -> tuple[BufferSpec, ...]:
        """What the graph makes for the overlay's vertices."""
        size = self.mesh.capacity * self.mesh.vertices_per_cell * _START.size
        starts = BufferSpec(f"{self.mesh.name}.starts", size, "persistent", "where vertices lie on the old surface")
        return (*self.mesh.vertex_buffers(), starts)

    @property
    def pending(self) -> bool:
        """Whether the overlay's vertices have to be made."""
        return self._pending and self.running

    def bind(self, io: PassIO) -> Callable[[], None]:
        """The pass that makes them all."""
        fresh = self.mesh.attach_vertices(io)
        starts, self._starts = getattr(self, "_starts", None), io.buffer(f"{self.mesh.name}.starts")
        if fresh or starts is not self._starts:  # what was made is gone
            self._laid = -1
            if not self._pending:
                self._age_s = np.inf

        def run() -> None:
            if not self._pending:
                return  # the graph runs every pass once
            self._agree()
            self._make(0, self.mesh.count)
            self._pending = False

        return run

    def _agree(self) -> None:
        """What each cell of the overlay skips."""
        assert self._old is not None
        mesh, count = self.mesh, self.mesh.count
        mesh.bind_made()
        mesh.bind_wanted()
        self._old[0].bind_to_storage_buffer(FADE_OLD_BUFFER)
        self._known.bind_to_storage_buffer(FADE_BUFFER)
        self._new.bind_made(cells=FADE_NEW_BUFFER, vertices=7)
        programs = self._programs
        programs.cells.set("u_cell_count", count)
        programs.cells.run(-(-count // 64), 1, 1)
        self._gpu.barrier()
        mesh.agree(programs.agree)

    def _make(self, first: int, count: int) -> None:
        """The vertices of `count` cells from `first` on (a multiple of the mesh's part_step)."""
        assert self._old is not None
        if count <= 0:
            return
        self.mesh.bind_part(first)
        self._starts.bind_to_storage_buffer(FADE_START_BUFFER, offset=first * self.mesh.vertices_per_cell * _START.size)
        self._old[1].bind_to_storage_buffer(FADE_OLD_BUFFER)
        self._known.bind_to_storage_buffer(FADE_BUFFER, offset=first * _CELL.size)
        self._new.bind_made(cells=7, vertices=FADE_NEW_BUFFER)
        vertices = self._programs.vertices
        vertices.set("u_shift", self._shift_m)
        vertices.set("u_rise", self._rise_m)
        vertices.run(count, 1, 1)
        self._gpu.barrier()

    def bind_draw(self) -> None:
        """What the vertex shader reads beyond cells and vertices."""
        self._starts.bind_to_storage_buffer(FADE_START_BUFFER)
        self._known.bind_to_storage_buffer(FADE_BUFFER)

    def read_changed(self) -> NDArray[np.bool_]:
        """Which cells of the overlay move, (cells,). Reads back from the GPU."""
        known = np.frombuffer(self._known.read(self.mesh.count * _CELL.size), _CELL.dtype)
        return known["changed"] != 0

    def read_starts(self) -> NDArray[np.float32]:
        """Where vertices start, (cells, vertices of a cell, 3), from the new anchor; undefined for cells that don't
        change. Reads back from the GPU."""
        count = self.mesh.count * self.mesh.vertices_per_cell
        found = np.frombuffer(self._starts.read(count * _START.size), _START.dtype)["position_m"]
        return found.reshape(self.mesh.count, self.mesh.vertices_per_cell, 3)
