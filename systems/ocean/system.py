"""OceanSystem: a sea in waves, drawn on cells of its own."""

from __future__ import annotations

from ...components import DebugView, Ocean, Planet
from ...engine.frame import Frame, ViewInfo
from ...engine.frame.unseen import Unseen
from ...engine.graph import GraphBuilder
from ...engine.settings import with_overrides
from ...engine.system import Setup, System
from .drawn import SeaMeshPasses
from .mesh import SeaMesh
from .paper_mesh import PaperSeaPasses, PaperSeaView
from .shading import SeaShading
from .wave_passes import SeaWaves


class OceanSystem(System):
    """The sea of one planet. Needs Planet and Ocean."""

    name = "ocean"
    needs = (Planet, Ocean)

    def __init__(self) -> None:
        self._waves = SeaWaves(self.name)
        self._mesh = SeaMeshPasses(self.name, self._waves)
        self._paper = PaperSeaPasses(self.name, self._waves)
        self._printed: bool | None = None
        self._shading = SeaShading(self.name)

    def setup(self, setup: Setup) -> None:
        self._views = setup.views
        self._unseen = Unseen(Ocean, Planet, DebugView)
        self._shading.setup(setup)
        self._waves.setup(setup)
        self._mesh.setup(setup)
        self._paper.setup(setup)

    def release(self) -> None:
        self._views.forget(self._paper)
        self._shading.release()

    def _view(self, index: int) -> SeaMesh:
        return self._views[index].state(self, lambda: self._mesh.view(index))

    def _paper_view(self, index: int) -> PaperSeaView:
        return self._views[index].state(self._paper, self._paper.view)

    def begin(self, frame: Frame) -> None:
        self._shading.begin(frame, self._waves.of(frame))

    def update(self, frame: Frame) -> None:
        if self._unseen.rests(frame):
            return
        ocean = with_overrides(frame.world.get(frame.planet, Ocean), "ocean", frame.settings)
        printed = ocean.method != "ours"
        if printed is not self._printed:
            self._printed = printed
            self.structure += 1
        if printed:
            frame.view.snap.take_part(False, "sea")
            paper = self._paper_view(frame.view_index)
            changed, waves = self._paper.update(frame, paper), paper.waves
        else:
            view = self._view(frame.view_index)
            changed, waves = self._mesh.update(frame, view), view.waves
        if changed:
            self.structure += 1
        self._waves.update(frame, waves)
        self._shading.update(frame, self._waves.of(frame))

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        if self._printed:
            self._paper.declare(builder, view.index, self._paper_view(view.index))
        else:
            sea = self._view(view.index)
            self._mesh.declare(builder, view, sea)
            self._waves.declare(builder, view, sea.waves)
        self._shading.declare(builder, view)

    def statistics(self) -> dict[str, int]:
        found = self._statistics()
        return found if self._views[0].seen.ground() else dict.fromkeys(found, 0)

    def _statistics(self) -> dict[str, int]:
        if self._printed:
            return self._paper.statistics(self._paper_view(0))
        sea = self._views.found(0, self, SeaMesh)
        return {} if sea is None else sea.mesh.statistics()
