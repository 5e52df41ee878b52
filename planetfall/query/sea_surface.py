"""The moving sea below a swimmer: OceanSampler of a scene as it is now, asked at most once a frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..components import Ocean, Terrain
from ..engine.settings import PartRevision
from .ocean import OceanSampler

if TYPE_CHECKING:
    from ..scene.scene import Scene

__all__ = ["SeaSurface"]

_NEAR = 1e-3
"""Directions this near (6 km on Earth) may share an answer within one frame: a frame's steps are far shorter."""


class SeaSurface:
    """height(direction): of the sea above the reference sphere at `time_s`, waves included.

    Sub-steps of one frame share the answer for the frame's first place.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._sampler: OceanSampler | None = None
        self._key: tuple[PartRevision, ...] = ()
        self._known: tuple[float, NDArray[np.float64], float] | None = None
        self.time_s = 0.0

    def height(self, direction: NDArray[np.float64]) -> float:
        """Metres above the reference sphere. There has to be an Ocean."""
        planet = self._scene.planet
        parts = (planet.planet, planet.get(Ocean), planet.get(Terrain))
        key = tuple(PartRevision.of(part) for part in parts if part is not None)
        if key != self._key or self._sampler is None:
            self._key, self._sampler, self._known = key, OceanSampler(self._scene), None
        known = self._known
        if known is not None and known[0] == self.time_s and float(np.abs(known[1] - direction).max()) < _NEAR:
            return known[2]
        height = float(self._sampler.height(direction[None], self.time_s)[0])
        self._known = (self.time_s, direction, height)
        return height
