"""OceanSystem: a sea in waves, drawn on cells of its own."""

from __future__ import annotations

from ...components import DebugView, Ocean, Planet
from ...engine.frame import Frame, ViewInfo
from ...engine.frame.unseen import Unseen
from ...engine.gpu import GpuScope
from ...engine.graph import GraphBuilder
from ...engine.methods import Methods
from ...engine.settings import Settings, with_overrides
from ...engine.system import Setup, System
from ...engine.waves import wave_method
from .method import SeaMethod
from .ours import OurSea
from .paper import PaperSea
from .shading import SeaShading
from .wave_passes import SeaWaves

_METHODS: dict[str, type[SeaMethod]] = {"ours": OurSea, "paper_2018": PaperSea, "paper_2019": PaperSea}


class OceanSystem(System):
    """The sea of one planet. Needs Planet and Ocean."""

    name = "ocean"
    needs = (Planet, Ocean)

    def __init__(self) -> None:
        self._waves = SeaWaves(self.name)
        self._shading = SeaShading(self.name)
        self._methods: Methods[SeaMethod]

    def setup(self, setup: Setup) -> None:
        self._setup = setup
        self._methods = Methods(setup.gpu, setup.views)
        self._unseen = Unseen(Ocean, Planet, DebugView, ground=True)
        self._shading.setup(setup)
        self._waves.setup(setup)
        self._use_method(setup.world.get(setup.planet, Ocean), setup.settings)

    def release(self) -> None:
        self._methods.release()
        self._shading.release()

    @property
    def method(self) -> SeaMethod:
        """What draws the water now."""
        return self._methods.now

    def _use_method(self, ocean: Ocean, settings: Settings) -> None:
        chosen = with_overrides(ocean, "ocean", settings)
        kind = _METHODS[chosen.method]
        arc = wave_method(chosen.method).printed if chosen.printed_arcs else 0

        def make(gpu: GpuScope) -> SeaMethod:
            of = (gpu, self._setup, self._waves)
            return PaperSea(*of, arc) if kind is PaperSea else kind(*of)

        self._methods.use(kind, make, arc)

    def begin(self, frame: Frame) -> None:
        self._shading.begin(frame, self._waves.of(frame))

    def update(self, frame: Frame) -> None:
        if self._unseen.rests(frame) and (self._rests(frame) or not frame.view.seen.planet()):
            return
        self._use_method(frame.world.get(frame.planet, Ocean), frame.settings)
        self.method.update(frame)
        self.structure += self._methods.changed()
        self._waves.update(frame, self.method.view(frame.view).waves)
        self._shading.update(frame, self._waves.of(frame))

    def _rests(self, frame: Frame) -> bool:
        """Whether nothing but to draw the water is left to do."""
        return self._waves.warm and self._shading.warm and self.method.rests(frame)

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        self.method.declare(builder, view)
        self._shading.declare(builder, view)

    def statistics(self) -> dict[str, int]:
        found = self.method.statistics()
        return found if self._setup.views[0].seen.ground() else dict.fromkeys(found, 0)
