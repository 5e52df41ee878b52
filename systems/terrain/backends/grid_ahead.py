"""The next snap's cells and vertices, made over some frames in a mesh of their own (engine/frame/snapping.py)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from ....engine.frame import Frame
from ....engine.frame.snapping import SnapAhead
from ....engine.gpu import GpuScope
from ....engine.gpu.cell_mesh import CellMesh
from ....engine.gpu.uniforms import UniformBlock
from ....engine.mesh_ahead import MeshAhead
from ....engine.surface.selection import CellSet
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


class GridAhead(MeshAhead):
    """One view's. `update` does a frame's share of CPU work, the pass its share on the GPU.

    key: the proxy's generation and the ground's revision.
    """

    phase: ClassVar[str] = "ground"

    def __init__(self, gpu: GpuScope, quads: int, making: GridMaking) -> None:
        super().__init__(CellMesh(gpu, "terrain_ahead", quads))
        self._making = making
        self.choice = Choice()

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

        def chosen() -> CellSet:
            self.choice = choose(frame, ground, snap.proxy, self.mesh.quads, *scale)
            assert self.choice.cells is not None
            return self.choice.cells

        snap.ground = self
        if snap.phase == "ground":
            return self.advance(snap, key, scale, chosen)
        if snap.phase != "fade":
            return False
        # A setting changed after the ground was made: it is made at once at the snap.
        if not self.begun(snap, key) or fade is None or shown.cells is None:
            snap.finish("fade")
        elif not fade.running and not fade.laying:
            return fade.lay(shown, self.choice, self.mesh)
        return False

    def make(self, snap: SnapAhead, first: int, count: int) -> None:
        """See MeshAhead."""
        made, choice = self._making, self.choice
        assert snap.bind_heights is not None, "terrain's own"
        snap.bind_heights()
        made.block.spacing = choice.spacing  # views take turns with it
        made.ubo.write(made.block)
        made.ubo.bind()
        self.mesh.make_part(
            made.vertices, made.measure, choice.eye_m, choice.edge_rad, choice.chord_m, made.most, first, count
        )

    def agree(self) -> None:
        """See MeshAhead."""
        self.mesh.agree(self._making.agree)

    def lay_part(self, fade: SnapFade, programs: FadePrograms) -> None:
        """In the pass of the fade: a share of the overlay's vertices."""
        snap = self._snap
        if snap is None or snap.phase != "fade" or not fade.laying:
            return
        if fade.lay_part(programs, snap.part("fade", fade.mesh.count, fade.mesh.part_step)):
            snap.finish("fade")
