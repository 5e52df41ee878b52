"""OceanSystem: a sea in waves, drawn on cells of its own."""

from __future__ import annotations

from ...components import Ocean, Planet
from ...engine.graph import GraphBuilder
from ...engine.system import Frame, Setup, System, ViewInfo
from .mesh import SeaMeshPasses, SeaView
from .shading import SeaShading
from .wave_passes import SeaWaves


class OceanSystem(System):
    """The sea of one planet. Needs Planet and Ocean."""

    name = "ocean"
    needs = (Planet, Ocean)

    def __init__(self) -> None:
        self._views: dict[int, SeaView] = {}
        self._waves = SeaWaves(self.name)
        self._mesh = SeaMeshPasses(self.name, self._waves)
        self._shading = SeaShading(self.name)

    def setup(self, setup: Setup) -> None:
        self._shading.setup(setup)
        self._waves.setup(setup)
        self._mesh.setup(setup)

    def release(self) -> None:
        self._views.clear()
        self._shading.release()

    def _view(self, index: int) -> SeaView:
        view = self._views.get(index)
        if view is None:
            view = self._views[index] = self._mesh.view(self._waves.view())
        return view

    def begin(self, frame: Frame) -> None:
        self._shading.begin(frame, self._waves.of(frame))

    def update(self, frame: Frame) -> None:
        view = self._view(frame.view_index)
        if self._mesh.update(frame, view):
            self.structure += 1
        self._waves.update(frame, view.waves)
        self._shading.update(frame, self._waves.of(frame))

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        sea = self._view(view.index)
        self._mesh.declare(builder, view, sea)
        self._waves.declare(builder, view, sea.waves)
        self._shading.declare(builder, view)

    def statistics(self) -> dict[str, int]:
        sea = self._views.get(0)
        return {} if sea is None else sea.mesh.statistics()
