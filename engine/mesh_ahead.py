"""Cells and vertices for the next snap of a view's proxy, made over some frames in a mesh of their own."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

from .frame.snapping import SnapAhead
from .gpu.cell_mesh import CellMesh
from .graph import PassIO
from .surface.decimation import topology
from .surface.selection import CellSet

__all__ = ["MeshAhead"]


class MeshAhead:
    """One view's, of one maker (engine/frame/snapping.py). Its system calls `advance` while it may choose cells, and
    declares a pass that `bind` makes, to run while `due`.

    key: what the mesh is made for; scale: as HeldScale.value.
    """

    phase: ClassVar[str]
    """In which it makes vertices."""

    def __init__(self, mesh: CellMesh) -> None:
        self.mesh = mesh
        self.key: tuple[Any, ...] = ()
        self.scale = (0.0, 0.0)
        self._snap: SnapAhead | None = None
        self._number = -1
        self._cells: CellSet | None = None
        self._uploaded = self._agreed = False
        self._turn = False  # this frame's; where another's phase ends in a frame, the next one begins in the next
        self._done = 0  # cells with vertices

    def complete(self, key: tuple[Any, ...]) -> bool:
        """Whether the mesh is the one for this key."""
        return self._agreed and key == self.key

    def made(self, snap: SnapAhead) -> CellSet | None:
        """The cells for that snap, if they have their vertices."""
        return self._cells if self._agreed and snap.number == self._number else None

    @property
    def due(self) -> bool:
        """Whether the GPU has something to do in this frame."""
        snap = self._snap
        return self._turn and snap is not None and snap.phase == self.phase and snap.number == self._number

    def begun(self, snap: SnapAhead, key: tuple[Any, ...]) -> bool:
        """Whether cells have been chosen for that snap and that key."""
        return snap.number == self._number and key == self.key

    def advance(
        self, snap: SnapAhead, key: tuple[Any, ...], scale: tuple[float, float], choose: Callable[[], CellSet]
    ) -> bool:
        """CPU work of one frame: first the choice, in the next frame its upload; with both goes a share of the vertices
        where there is no time to lose, and room. True where buffers of the graph grew."""
        self._snap = snap
        if not self.begun(snap, key):
            self._number, self.key, self.scale = snap.number, key, scale
            self._uploaded = self._agreed = self._turn = False
            self._cells, self._done = choose(), 0
            # More room would cost what is there, which may not have been taken yet.
            fits = max(len(self._cells.face), snap.room) <= self.mesh.capacity
            if not (snap.hurried and snap.phase == self.phase and fits):
                return False
            snap.begin_early()
        self._turn = snap.phase == self.phase
        if self._uploaded or self._cells is None:
            return False
        self._uploaded = True
        grew = self.mesh.reserve(snap.room) | self.mesh.upload(self._cells, topology(self._cells))
        snap.room = max(snap.room, self.mesh.capacity)
        return grew

    def make_room(self, snap: SnapAhead) -> bool:
        """As much room as another maker has come to need, before cells are uploaded and once those of the last snap
        were taken: the graph is compiled once for both. True where buffers of the graph grew."""
        return not self._uploaded and self.mesh.reserve(snap.room)

    def bind(self, io: PassIO) -> Callable[[], None]:
        """The pass that makes a share of the vertices."""
        if self.mesh.attach_vertices(io):
            self._done, self._agreed = 0, False

        def run() -> None:
            snap = self._snap
            if snap is None or not self.due:
                return  # the graph runs every pass once
            part = snap.part(self.phase, self.mesh.count, self.mesh.part_step, self._done == 0)
            count = min(part, self.mesh.count - self._done)
            if count > 0:
                snap.bind_anchor()
                self.make(snap, self._done, count)
                snap.restore_anchor()
                self._done += count
            if self._done >= self.mesh.count:
                self.agree()
                self._agreed = True
                snap.finish(self.phase)

        return run

    def make(self, snap: SnapAhead, first: int, count: int) -> None:
        """The vertices of `count` cells from `first` on, around the next anchor."""
        raise NotImplementedError

    def agree(self) -> None:
        """What cells may skip, once all have their vertices."""
        raise NotImplementedError
