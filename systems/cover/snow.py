"""Snow that trees carry: near the snow line all year, lower down in winter, as on the ground."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...components import Cover
from ...components.season import winter_at
from .growth import Growing, ramp

__all__ = ["SnowFall"]

Floats = NDArray[np.float64]

_COLD = (0.16, 0.01)
"""Warmth (growth.Climate) between which trees come to carry it in summer; as SNOW_COLD of cover/snow_share.glsl."""
_WINTER = 0.39
"""By how much midwinter is colder; as SNOW_WINTER there. At the sea's level snow then lies from 45 degrees on: chosen
by eye."""


@dataclass(frozen=True)
class SnowFall:
    """What decides how much of it a tree carries."""

    growing: Growing
    radius_m: float
    """of the planet"""
    keeps: float
    """Cover.snow"""
    season: float
    """Cover.season"""

    @classmethod
    def of(cls, growing: Growing, radius_m: float, cover: Cover) -> SnowFall:
        """As a component has it."""
        return cls(growing, radius_m, cover.snow, cover.season)

    def on(self, positions_m: Floats) -> Floats:
        """Share (N,) of what faces up that is white, on trees at planet-centred places (N, 3)."""
        if self.keeps <= 0.0 or not len(positions_m):
            return np.zeros(len(positions_m))
        away = np.linalg.norm(positions_m, axis=1)
        sine = positions_m[:, 2] / away
        warmth = self.growing.warmth(sine, away - self.radius_m)
        return self.keeps * ramp(*_COLD, warmth - _WINTER * winter_at(self.season, sine))

    def winters(self) -> Floats:
        """(2,) of the northern and the southern half, where leaves fall."""
        return winter_at(self.season, np.array([1.0, -1.0]))
