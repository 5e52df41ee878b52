"""Noise that moves water on its valley's floor: vectors at the bent place, for meanders and for uneven banks.

Far from the water nothing of it is left, so that most places on land ask none. It counts in whole steps of nodes'
places, as the GPU does (river_ask_noise of assets/shaders/terrain/rivers.glsl): no lattice has an anchor.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ....engine.surface.noise import Lattice
from .form import WATER_OCTAVES

__all__ = ["WATER_OFFSET", "water_lattice", "water_wavelengths_m"]

Floats = NDArray[np.float64]

WATER_OFFSET = 1013
"""Cells by which each lattice is shifted along all axes from the one before."""
_MOST_BITS = 30


def water_wavelengths_m(step_m: float) -> Floats:
    """4096, 1024, 256, 64 and 16 m, in steps of nodes' places a power of two; of small planets, whose steps are a part
    of a micrometre, no longer ones than whole numbers hold."""
    longest = min(12 - round(math.log2(step_m)), _MOST_BITS)
    return np.array([step_m * 2.0 ** (longest - 2 * k) for k in range(WATER_OCTAVES)])


def water_lattice(step_m: float) -> Lattice:
    """Octaves of that noise, the longest first."""
    offsets = WATER_OFFSET * np.arange(1.0, WATER_OCTAVES + 1.0)
    return Lattice.of(water_wavelengths_m(step_m), np.repeat(offsets[:, None], 3, axis=1))
