"""Banks that are uneven: the water's half width differs from that of its line, by noise at the bent place:
one component of the vectors that also bend lines.

Far from the water nothing of it is left, so that most places on land ask no noise. It counts in whole steps of nodes'
places, as the GPU does (river_bent of assets/shaders/terrain/rivers.glsl): no lattices of its own around an anchor.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ....engine.surface.noise import Corners, Lattice
from .form import BANK_COARSE_M, BANK_FAR, BANK_FINE_M, BANK_MIDDLE_M, river_bank

__all__ = ["BANK_OFFSETS", "bank_bits", "bank_lattice", "uneven"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

BANK_OFFSETS = (3039, 4052, 5065)
"""Cells by which the three lattices, coarse, middle and fine, are shifted along all axes."""


def bank_bits(step_m: float) -> tuple[int, int, int]:
    """Logarithms of the three wavelengths, in steps of nodes' places; of small planets, whose steps are a part of a
    micrometre, no more than whole numbers hold."""
    bits = [round(math.log2(m / step_m)) for m in (BANK_COARSE_M, BANK_MIDDLE_M, BANK_FINE_M)]
    return min(bits[0], 30), min(bits[1], 28), min(bits[2], 26)


def bank_lattice(step_m: float) -> Lattice:
    """Octaves of the noise of banks."""
    return Lattice.of([step_m * 2.0**b for b in bank_bits(step_m)], np.repeat(np.array([BANK_OFFSETS]).T, 3, axis=1))


def uneven(lattice: Lattice, share: float, bent: Floats, d: Floats, value: Floats) -> tuple[Floats, Indices, Corners]:
    """Half widths (P,) between banks of P pairs, which of the pairs noise may move (Q,), and that noise's corners.

    bent: (3, P); d, value: as Pairs has them; share: how uneven, 0..1.
    """
    near = np.flatnonzero(d < BANK_FAR * value[1]) if share > 0.0 else np.empty(0, np.int64)
    corners = lattice.cells(bent.take(near, axis=1))
    bank = value[1].copy()
    if near.size:
        bank[near] = river_bank(d[near], value[1, near], value[3, near], share, *corners.vector()[0])
    return bank, near, corners
