"""The next snap's cells and vertices, made over some frames in a mesh of their own (engine/snap_ahead.py)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ....engine.gpu import GpuScope
from ....engine.gpu.cell_mesh import CellMesh
from ....engine.gpu.uniforms import UniformBlock
from ....engine.graph import PassIO
from ....engine.snap_ahead import SnapAhead
from ....engine.surface.decimation import topology
from ....engine.system import Frame
from .base import Ground
from .grid_choice import Choice, choose
from .grid_fade import FadePrograms, SnapFade

__all__ = ["GridAhead", "GridMaking"]


@dataclass
class GridMaking:
    """What makes vertices, shared by all views."""

    vertices: Any
    measure: Any
    agree: Any
    ubo: UniformBlock
    block: Any
    """Of the grid that is prepared, and its values."""
    most: int


class GridAhead:
    """One view's. `update` does a frame's share of CPU work, the pass its share on the GPU.

    key: what the mesh is made for: the proxy's generation and the ground's revision; scale: as HeldScale.value.
    """

    def __init__(self, gpu: GpuScope, quads: int, making: GridMaking) -> None:
        self._gpu, self._making = gpu, making
        self.mesh = CellMesh(gpu, "terrain_ahead", quads)
        self.choice = Choice()
        self.key: tuple[Any, ...] = ()
        self.scale = (0.0, 0.0)
        self._number = -1
        self._uploaded = False
        self._done = 0  # cells with vertices
        self._agreed = False
        self._snap: SnapAhead | None = None

    def complete(self, key: tuple[Any, ...]) -> bool:
        """Whether the mesh is the one for this key."""
        return self._agreed and key == self.key

    def update(
        self,
        frame: Frame,
        ground: Ground,
        snap: SnapAhead,
        key: tuple[Any, ...],
        scale: tuple[float, float],
        fade: SnapFade | None,
        shown: Choice,
    ) -> bool:
        """CPU work of one frame. key, scale: for the grid of `snap.proxy`. shown: what
        is drawn. True where buffers of the graph grew."""
        self._snap = snap
        if snap.phase not in ("ground", "fade"):
            return False
        if snap.number != self._number or key != self.key:
            if snap.phase == "fade":  # a setting changed after the ground was made: it is made at once at the snap
                snap.finish("fade")
                return False
            self._number, self.key, self.scale = snap.number, key, scale
            self._uploaded = self._agreed = False
            self._done = 0
            self.choice = choose(frame, ground, snap.proxy, self.mesh.quads, *scale)
            return False
        if snap.phase == "ground" and not self._uploaded:
            assert self.choice.cells is not None
            self._uploaded, self._done = True, 0
            return self.mesh.upload(self.choice.cells, topology(self.choice.cells))
        if snap.phase == "fade" and (fade is None or shown.cells is None):
            snap.finish("fade")
        elif snap.phase == "fade" and fade is not None and not fade.running and not fade.laying:
            return fade.lay(shown, self.choice, self.mesh)
        return False

    @property
    def due(self) -> bool:
        """Whether the GPU has something to do in this frame."""
        snap = self._snap
        return snap is not None and snap.phase == "ground" and self._uploaded and snap.number == self._number

    def bind(self, io: PassIO) -> Callable[[], None]:
        """The pass that makes a share of the vertices."""
        if self.mesh.attach_vertices(io):
            self._done, self._agreed = 0, False

        def run() -> None:
            snap = self._snap
            if not self.due or snap is None or snap.bind_heights is None:
                return  # the graph runs every pass once
            made, mesh, choice = self._making, self.mesh, self.choice
            count = min(snap.part("ground", mesh.count, mesh.part_step), mesh.count - self._done)
            if count > 0:
                snap.bind_anchor()
                snap.bind_heights()
                made.block.spacing = choice.spacing  # views take turns with it
                made.ubo.write(made.block)
                made.ubo.bind()
                mesh.make_part(
                    made.vertices, made.measure, choice.eye_m, choice.edge_rad, choice.chord_m, made.most,
                    self._done, count,
                )  # fmt: skip
                snap.restore_anchor()
                self._done += count
            if self._done >= mesh.count:
                mesh.agree(made.agree)
                self._agreed = True
                snap.finish("ground")

        return run

    def lay_part(self, fade: SnapFade, programs: FadePrograms) -> None:
        """In the pass of the fade: a share of the overlay's vertices."""
        snap = self._snap
        if snap is None or snap.phase != "fade" or not fade.laying:
            return
        if fade.lay_part(programs, snap.part("fade", fade.mesh.count, fade.mesh.part_step)):
            snap.finish("fade")
