"""What the wind does to plants at a moment: how far it bends them, and the gusts that run over them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ...components import Wind
from ...engine.space.axes import direction, heading_pitch_axes

__all__ = ["GUSTS", "STILL", "Sway", "sway_at"]

Floats = NDArray[np.float64]

GUSTS = 3
_GUST_M = (23.0, 9.1, 5.3)
"""Wavelengths of the gusts that run over a meadow."""
_GUST_DEG = (0.0, 35.0, -28.0)
"""Their headings, from the wind's."""
_GUST_SPEED = 0.7
"""Of gusts near the ground, over the wind's 10 m above it."""
_MOST, _HALF_M_S = 0.75, 13.0
"""The most that a tip is moved aside, over its height; and about the wind that does half of it. Chosen by eye."""
_STRENGTH = 0.45
"""Of one gust's crest and trough, over the wind's, at Wind.gusts 1."""
_FLUTTER_HZ = 1.3
_LEVEL_LEAST = 0.1
"""Share of the wind's direction that lies along the ground, below which it dies down: it has to somewhere."""


@dataclass(frozen=True)
class Sway:
    """For one camera and one moment, in planet axes."""

    bend: Floats
    """(3,) along the ground: what tips are moved by, over their height"""
    gusts: Floats
    """(GUSTS, 4) cycles per metre, (3,), and the phase at the camera, in cycles"""
    gusting: float
    """share by which one gust's crest strengthens that"""
    flutter: float
    """phase of the leaves' own motion, 0..1"""


STILL = Sway(np.zeros(3), np.zeros((GUSTS, 4)), 0.0, 0.0)


def sway_at(wind: Wind, camera_m: Floats, time_s: float) -> Sway:
    """camera_m: (3,) from the planet's centre, float64. A gust is a wave along a straight line through the planet, so
    its phase is the same from wherever it is asked, and there is no seam."""
    up = camera_m / np.linalg.norm(camera_m)
    ahead, gusts_m = _headings(tuple(wind.at), wind.direction_deg)
    level = ahead - (ahead @ up) * up
    level /= max(float(np.linalg.norm(level)), _LEVEL_LEAST)
    strength = _MOST * (1.0 - np.exp(-((wind.speed_m_s / _HALF_M_S) ** 1.5)))
    runs = time_s * _GUST_SPEED * wind.speed_m_s / np.array(_GUST_M)
    gusts = np.column_stack([gusts_m, np.mod(gusts_m @ camera_m - runs, 1.0)])
    return Sway(strength * level, gusts, _STRENGTH * wind.gusts, float(np.mod(time_s * _FLUTTER_HZ, 1.0)))


@lru_cache(maxsize=8)
def _headings(at: tuple[float, float], direction_deg: float) -> tuple[Floats, Floats]:
    """Unit vector (3,) that the wind blows along, and of its gusts (GUSTS, 3), cycles per metre."""
    place = direction(*at)
    ahead, *gusts = (heading_pitch_axes(place, direction_deg + turned_deg, 0.0)[0] for turned_deg in (0.0, *_GUST_DEG))
    return ahead, np.stack(gusts) / np.array(_GUST_M)[:, None]
