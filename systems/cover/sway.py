"""What the wind does to plants at a moment: how far it bends them, and the gusts that run over them."""

from __future__ import annotations

from dataclasses import dataclass

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
    at = direction(*wind.at)
    ahead = heading_pitch_axes(at, wind.direction_deg, 0.0)[0]
    level = ahead - (ahead @ up) * up
    level /= max(float(np.linalg.norm(level)), _LEVEL_LEAST)
    strength = _MOST * (1.0 - np.exp(-((wind.speed_m_s / _HALF_M_S) ** 1.5)))
    gusts = np.empty((GUSTS, 4))
    for k, (length_m, turned_deg) in enumerate(zip(_GUST_M, _GUST_DEG, strict=True)):
        along = heading_pitch_axes(at, wind.direction_deg + turned_deg, 0.0)[0] / length_m
        gusts[k, :3] = along
        gusts[k, 3] = np.mod(along @ camera_m - time_s * _GUST_SPEED * wind.speed_m_s / length_m, 1.0)
    return Sway(strength * level, gusts, _STRENGTH * wind.gusts, float(np.mod(time_s * _FLUTTER_HZ, 1.0)))
