"""SeaMethod: how the water gets into the G-buffer; shading is the ocean system's and shared."""

from __future__ import annotations

from abc import abstractmethod
from typing import Protocol

from ...components import Ocean
from ...engine.frame import Frame, View
from ...engine.gpu import GpuScope
from ...engine.methods import Method
from ...engine.settings import revision
from ...engine.system import Setup
from .wave_passes import SeaWaves, WaveView

__all__ = ["SeaMethod", "surface_of"]


def surface_of(frame: Frame) -> tuple[int, int]:
    """What the water's mesh depends on in any case: the sea, and the ground that it is cut against."""
    world = frame.world
    return revision(world.get(frame.planet, Ocean)), id(world.resources.get("height_field"))


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
