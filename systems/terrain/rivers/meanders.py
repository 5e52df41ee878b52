"""Meanders: rivers of gentle valleys wander over their floors, while the valleys about them stay where they are.

The bent place is moved once more, by vector noise, before it is held against a line's water. How far at most is a
node's number, and the noise's wavelength goes with it, so lines that share a node share the way the place is moved, and
rivers still join.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .form import MEANDER_HALF_WIDTHS, MEANDER_NARROW, MEANDER_OCTAVES, MEANDER_ROOM, MEANDER_SHARE, MEANDER_STEEP

__all__ = ["meanders", "octave_weights"]

Floats = NDArray[np.float64]

_LEAST_M = 1e-3
"""What moves water by less has the shortest wavelength."""


def meanders(to: NDArray[np.int32], place_m: Floats, values: NDArray[np.float32]) -> NDArray[np.float32]:
    """How far rivers wander at nodes (N,), m: 0 in lakes, below the sea, at falls and where there is no room.

    to (N,): nodes downstream, -1: none; place_m (N, 3); values (N, 8): as RiverTable has them.
    """
    level, half, floor, lake = (values[:, k].astype(np.float64) for k in (0, 1, 3, 5))
    line = np.flatnonzero(to >= 0)
    below = to[line]
    length = np.sqrt(((place_m[below] - place_m[line]) ** 2).sum(axis=1))
    slope = np.abs(level[line] - level[below]) / np.maximum(length, 1.0)
    steepest = np.zeros(len(to))
    np.maximum.at(steepest, line, slope)
    np.maximum.at(steepest, below, slope)
    gentle = np.clip(1.0 - steepest / MEANDER_STEEP, 0.0, 1.0)
    most = np.minimum(MEANDER_SHARE * MEANDER_HALF_WIDTHS * half * gentle, MEANDER_ROOM * (floor - half))
    most = np.where((lake > 0.5) | (level <= 0.0) | (floor < MEANDER_NARROW * half) | (half <= 0.0), 0.0, most)
    most[to < 0] = 0.0
    # At the bank of a wider river that it joins, a stream goes where that goes.
    short = length < 2.0 * half[below]
    most[line[short]] = most[below[short]]
    return most.astype(np.float32)


def octave_weights(metres: Floats, longest_m: float) -> tuple[Floats, Floats]:
    """Of octaves (4, Q), each a quarter as long as the one before, for rivers that wander by metres (Q,); and how they
    change with that."""
    metres = np.maximum(metres, _LEAST_M)
    x = 0.5 * np.log2(longest_m * MEANDER_SHARE / metres)
    inside = (x > 0.0) & (x < MEANDER_OCTAVES - 1.0)
    off = np.clip(x, 0.0, MEANDER_OCTAVES - 1.0) - np.arange(float(MEANDER_OCTAVES))[:, None]
    weights = np.maximum(1.0 - np.abs(off), 0.0)
    by_x = np.where(weights > 0.0, -np.sign(off), 0.0)
    return weights, by_x * np.where(inside, -0.5 / (math.log(2.0) * metres), 0.0)
