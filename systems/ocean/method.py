"""SeaMethod: how the water gets into the G-buffer; shading is the ocean system's and shared."""

from __future__ import annotations

from abc import abstractmethod
from typing import Protocol

from ...engine.frame import Frame
from ...engine.gpu import GpuScope
from ...engine.methods import Method
from ...engine.system import Setup
from .wave_passes import SeaWaves, WaveView

__all__ = ["SeaMethod"]


class _SeaView(Protocol):
    waves: WaveView


class SeaMethod(Method):
    """One of Ocean.method: passes that end in ``ocean.gbuffer`` and give its pixels ``ocean.rough``."""

    def __init__(self, gpu: GpuScope, setup: Setup, waves: SeaWaves) -> None:
        super().__init__(gpu)
        self.world, self.views, self.waves = setup.world, setup.views, waves

    @abstractmethod
    def view(self, index: int) -> _SeaView:
        """What it keeps for a view."""

    def unchanged(self, frame: Frame) -> bool:
        """Whether `update` would do nothing but look."""
        return False
