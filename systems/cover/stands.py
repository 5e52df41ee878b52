"""Stands of a forest: patches of older and younger trees, of lighter and darker greens, and glades between them.

Twin of assets/shaders/terrain/stands.glsl, so that woods go on where trees are no longer solids.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...engine.surface.nested import NESTED_BASE_M
from ...engine.surface.noise import Lattice
from .growth import ramp

__all__ = ["STAND_CONIFERS", "STAND_SIZES", "glade", "stands"]

Floats = NDArray[np.float64]

_OCTAVES = np.array([12, 10, 14])
"""Of NESTED_BASE_M times 2 to these: stands of 256 m, groups of 64 m, and regions of a kilometre."""
_SHIFTS = np.array([0.618034, 0.754878, 0.569840])
_GRADIENT_RMS = 0.27
_AGE, _HUE, _GLADE = (1.5, 0.6), (1.5, 0.8), (0.75, 0.65)
_REGION = (0.20, 0.30)
_GLADE_ENDS, _GLADE_BARE = (-0.46, -0.62), 0.85
STAND_CONIFERS = 0.08
"""By what darker ones count as colder."""
STAND_SIZES = (0.16, 0.25)
"""Of the widths of crowns and of heights, by age."""
_LATTICE = Lattice.of(
    NESTED_BASE_M * 2.0**_OCTAVES, np.modf(_SHIFTS * (_OCTAVES[:, None] + 1.0))[0] + 7919.0 * _OCTAVES[:, None]
)


def stands(directions: Floats, radius_m: float) -> Floats:
    """(3, N) at unit directions (N, 3): how old a stand is, -1..1 and beyond; how light and yellowish its leaves are,
    the same; and what glades follow from."""
    corners = _LATTICE.cells(radius_m * directions.T)
    wide, narrow = corners.part(slice(0, 2)).vector().swapaxes(0, 1)
    region = corners.part(slice(2, 3)).noise()[0] / _GRADIENT_RMS
    found = np.stack([a * wide[k] + b * narrow[k] for k, (a, b) in enumerate((_AGE, _HUE, _GLADE))])
    found[:2] += np.array(_REGION)[:, None] * region
    return found


def glade(value: Floats) -> Floats:
    """0 closed woods .. share of the places that have no tree in a glade. value: the last of `stands`."""
    return _GLADE_BARE * ramp(*_GLADE_ENDS, value)
