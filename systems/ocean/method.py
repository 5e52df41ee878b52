"""SeaMethod: how the water gets into the G-buffer; shading is the ocean system's and shared."""

from __future__ import annotations

from abc import abstractmethod
from typing import NamedTuple, Protocol

from ...components import Ocean
from ...engine.frame import Frame, View
from ...engine.frame.published import HEIGHT_FIELD
from ...engine.gpu import GpuScope
from ...engine.methods import Method
from ...engine.settings import revision
from ...engine.system import Setup
from .wave_passes import SeaWaves, WaveMoment, WaveView

__all__ = ["Displaced", "SeaMethod", "SeaSurface"]


class SeaSurface(NamedTuple):
    """What the water's mesh depends on in any case. sea: its revision; ground: id of what it is cut against."""

    sea: int
    ground: int

    @classmethod
    def of(cls, frame: Frame) -> SeaSurface:
        """That of a frame."""
        world = frame.world
        return cls(revision(world.get(frame.planet, Ocean)), id(world.try_resource(HEIGHT_FIELD)))


class Displaced(NamedTuple):
    """What displaced vertices depend on. made: the selection whose vertices exist; culled: what its list was made for;
    moment: of the waves."""

    made: int | None
    culled: object
    moment: WaveMoment | None


class _SeaView(Protocol):
    waves: WaveView

    def rests(self, frame: Frame) -> bool: ...


class SeaMethod(Method):
    """One of Ocean.method: passes that end in ``ocean.gbuffer`` and give its pixels ``ocean.rough``."""

    def __init__(self, gpu: GpuScope, setup: Setup, waves: SeaWaves) -> None:
        super().__init__(gpu)
        self.world, self.views, self.waves = setup.world, setup.views, waves

    @abstractmethod
    def view(self, view: View) -> _SeaView:
        """What it keeps for a view."""

    def rests(self, frame: Frame) -> bool:
        """Whether `update` would do nothing but look."""
        return self.view(frame.view).rests(frame)
