"""What the time of year does to broadleaf trees and shrubs: autumn's colours, and bare branches in winter."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...components.season import seasonal, year_of

__all__ = ["AUTUMN", "LIKE_BARK", "SUMMER", "TWIGS_OPEN", "Leaves", "leaves_at"]

Floats = NDArray[np.float64]

_TURN = (0.68, 0.80)
"""Share of the year, from midwinter on, in which leaves turn."""
_FALL = (0.82, 0.92)
_GONE = (0.10, 0.22)
"""In which the last that have turned go, where only some trees shed theirs."""
_BUD = (0.22, 0.34)
LIKE_BARK = 0.9
"""How far a crown's colour goes to that of bark as it loses its leaves; as in assets/shaders/cover/gbuffer.frag."""
TWIGS_OPEN = 0.5
"""Share of a crown that one without leaves no longer hides."""
AUTUMN: Floats = np.array([[0.35, 0.19, 0.02], [0.30, 0.10, 0.015], [0.20, 0.04, 0.02], [0.17, 0.13, 0.03]])
"""Colours of leaves that have turned: gold, orange, red, brown-green; linear sRGB as they show in sunlight. Chosen by
eye."""


class Leaves(NamedTuple):
    """Of broadleaves at a place and a time: shares 0..1."""

    turned: float
    """of autumn's colours; each tree has its own day"""
    bare: float
    """of leaves that have fallen"""


SUMMER = Leaves(0.0, 0.0)


def leaves_at(season: float, sine: float) -> Leaves:
    """season: time of year, 0..1, 0 midwinter of the northern half; the southern is half a year apart. sine: of the
    latitude."""
    year, share = float(year_of(season, sine < 0.0)), float(seasonal(sine))

    def ramp(ends: tuple[float, float]) -> float:
        return min(max((year - ends[0]) / (ends[1] - ends[0]), 0.0), 1.0)

    winter = year < _BUD[1]
    bare = 1.0 - ramp(_BUD) if winter else ramp(_FALL)
    turned = 1.0 - ramp(_GONE) if winter else ramp(_TURN)
    return Leaves(share * turned, share * bare)
