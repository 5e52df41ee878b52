"""Cells and vertices for the next snap of a view's proxy, made over some frames in a mesh of their own."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

from ..frame.snapping import Scale, SnapAhead
from ..gpu import Compute
from ..gpu.cell_mesh import CellMesh
from ..graph import PassIO
from ..surface.decimation import topology
from .choice import CellChoice, MeshKey

__all__ = ["MeshAhead"]

C = TypeVar("C", bound=CellChoice)


class MeshAhead(Generic[C]):
    """One view's, of one maker (engine/frame/snapping.py). `advance` is called in every frame while a snap is prepared,
    and the pass that `bind` makes runs while `due`.

    phase: in which it makes vertices. make: those of some cells: (mesh, choice, first, count, snap). agree: see
    CellMesh.agree.
    """

    def __init__(
        self, mesh: CellMesh, phase: str, make: Callable[[CellMesh, C, int, int, SnapAhead], None], agree: Compute
    ) -> None:
        self.mesh, self.phase = mesh, phase
        self._make, self._agree = make, agree
        self.key: MeshKey | None = None
        """What the mesh is made for; `scale`, too."""
        self.scale = Scale(0.0, 0.0)
        self.choice: C | None = None
        self._snap: SnapAhead | None = None
        self._number = self._seen = -1
        self._uploaded = self._agreed = False
        self._turn = False  # this frame's; where another's phase ends in a frame, the next one begins in the next
        self._done = 0  # cells with vertices

    def complete(self, key: MeshKey) -> bool:
        """Whether the mesh is the one for this key."""
        return self._agreed and key == self.key

    def made(self, snap: SnapAhead) -> C | None:
        """The choice for that snap, if its cells have their vertices."""
        return self.choice if self._agreed and snap.number == self._number else None

    @property
    def due(self) -> bool:
        """Whether the GPU has something to do in this frame."""
        snap = self._snap
        return self._turn and snap is not None and snap.phase == self.phase and snap.number == self._number

    def begun(self, snap: SnapAhead, key: MeshKey) -> bool:
        """Whether cells have been chosen for that snap and that key."""
        return snap.number == self._number and key == self.key

    def advance(self, snap: SnapAhead, key: MeshKey, scale: Scale, choose: Callable[[], C]) -> bool:
        """CPU work of one frame, until its phase is over: whose phase it is chooses at once, others a frame later. True
        where buffers of the graph grew."""
        first, self._seen = snap.number != self._seen, snap.number
        if not snap.awaits(self.phase) or (first and snap.phase != self.phase):
            return False
        # As much room as another maker has come to need, before cells are uploaded and once those of the last snap were
        # taken: the graph is compiled once for both.
        return self._advance(snap, key, scale, choose) | (
            not (first or self._uploaded) and self.mesh.reserve(snap.room)
        )

    def _advance(self, snap: SnapAhead, key: MeshKey, scale: Scale, choose: Callable[[], C]) -> bool:
        """First the choice, in the next frame its upload; with both goes a share of the vertices where there is no time
        to lose, and room."""
        self._snap = snap
        if not self.begun(snap, key):
            self._number, self.key, self.scale = snap.number, key, scale
            self._uploaded = self._agreed = self._turn = False
            self.choice, self._done = choose(), 0
            # More room would cost what is there, which may not have been taken yet.
            fits = max(len(self.choice.cells), snap.room) <= self.mesh.capacity
            if not (snap.hurried and snap.phase == self.phase and fits):
                return False
            snap.begin_early()
        self._turn = snap.phase == self.phase
        if self._uploaded or self.choice is None:
            return False
        self._uploaded = True
        cells = self.choice.cells
        grew = self.mesh.reserve(snap.room) | self.mesh.upload(cells, topology(cells))
        snap.room = max(snap.room, self.mesh.capacity)
        return grew

    def bind(self, io: PassIO) -> Callable[[], None]:
        """The pass that makes a share of the vertices."""
        if self.mesh.attach_vertices(io):
            self._done, self._agreed = 0, False

        def run() -> None:
            snap, choice = self._snap, self.choice
            if snap is None or choice is None or not self.due:
                return  # the graph runs every pass once
            part = snap.part(self.phase, self.mesh.count, self.mesh.part_step, self._done == 0)
            count = min(part, self.mesh.count - self._done)
            if count > 0:
                snap.bind_anchor()
                self._make(self.mesh, choice, self._done, count, snap)
                snap.restore_anchor()
                self._done += count
            if self._done >= self.mesh.count:
                self.mesh.agree(self._agree)
                self._agreed = True
                snap.finish(self.phase)

        return run
