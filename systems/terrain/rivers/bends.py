"""The warp that bends straight lines into rivers: where it moves places, and which place it moves to one."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ....engine.surface.noise import Lattice, octave_offset

__all__ = ["BEND_CELLS", "BEND_SHARES", "bend_amplitudes_m", "bend_lattice", "river_cell_m", "unbent"]

Floats = NDArray[np.float64]

BEND_CELLS = (0.5, 0.0625)
"""Wavelengths of the warp that bends straight lines into rivers, in cells: 8 and 1 km on Earth."""
BEND_SHARES = (0.15, 0.15)
"""How far it moves a place along each axis at most, in wavelengths."""
_BEND_OCTAVES = (900, 901)
"""Numbers of the warp's octaves among all of a seed."""
_TURNS = 4
"""Steps to the warp's inverse."""


def river_cell_m(radius_m: float) -> float:
    """Width of the lattice's cells."""
    return float(2.0 ** (math.floor(math.log2(radius_m)) - 8))


def bend_lattice(cell_m: float, seed: int) -> Lattice:
    """Octaves of the vector noise that bends lines."""
    wavelengths = [share * cell_m for share in BEND_CELLS]
    return Lattice.of(wavelengths, np.array([octave_offset(seed, k) for k in _BEND_OCTAVES]))


def bend_amplitudes_m(cell_m: float) -> Floats:
    """Amplitudes of the warp's octaves, rounded to float32."""
    shares = np.array(BEND_CELLS) * np.array(BEND_SHARES) * cell_m
    return shares.astype(np.float32).astype(np.float64)


def unbent(points: Floats, radius_m: float, seed: int, more: int = 0) -> Floats:
    """(3, N) places on the reference sphere that the warp moves to points (3, N), m, but for some 50 m. more: steps, of
    which 16 leave some centimetres."""
    cell_m = river_cell_m(radius_m)
    lattice, amplitudes = bend_lattice(cell_m, seed), bend_amplitudes_m(cell_m)[:, None]
    long = Lattice(lattice.frequency[:1], lattice.offset[:1])
    found = points
    for turn in range(_TURNS + more):
        # The short octave moves places by a seventh of what the long one does.
        last = turn >= _TURNS - 1
        octaves, moves = (lattice, amplitudes) if last else (long, amplitudes[:1])
        found = points - (moves * octaves.cells(found).vector()).sum(axis=1)
        x, y, z = found
        found = found * (radius_m / np.sqrt(x * x + y * y + z * z))
    return found
