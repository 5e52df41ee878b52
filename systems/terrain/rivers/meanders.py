"""Meanders: rivers of gentle valleys wander over their floors, while the valleys about them stay where they are.

The bent place is moved once more, by vector noise, before it is held against a line's water. How far at most is a
node's number, and the noise's wavelength goes with it, so lines that share a node share the way the place is moved, and
rivers still join. From some widths on nothing is moved.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ....engine.surface.noise import Corners, Lattice
from .form import MEANDER_HALF_WIDTHS, MEANDER_NARROW, MEANDER_ROOM, MEANDER_SHARE, MEANDER_STEEP, wander_slopes

if TYPE_CHECKING:
    pass

__all__ = ["OCTAVES", "Wander", "meanders", "octave_offsets", "wander", "wander_by_place"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

OCTAVES = (3, 14)
"""Logarithms of the least and the largest wavelength, m."""
_OFFSET, _OFFSET_STEP = 5003, 101
"""Cells by which lattices are shifted along all axes: the first, and more for each octave."""


class Wander:
    """Pairs (Q,) of places and lines that are moved, and how."""

    def __init__(self, near: Indices, octave: Floats, corners: Corners, metres: Floats, share: Floats) -> None:
        """octave (2, Q): logarithms of wavelengths; metres (Q,): how far; share (Q,): of the longer octave."""
        self.near, self.octave, self.corners, self.metres, self.share = near, octave, corners, metres, share


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


def octave_offsets(octave: Floats) -> Floats:
    """Cells by which lattices of those octaves are shifted along all axes."""
    return _OFFSET + _OFFSET_STEP * octave


def wander(step_m: float, uneven: float, bent: Floats, d: Floats, value: Floats) -> tuple[Wander | None, Floats]:
    """Which of P pairs are moved, and to which places (3, Q). bent: (3, P); d, value: as Pairs has them."""
    reach = 2.5 * value[1] + 4.5 * value[7]
    near = np.flatnonzero((value[7] > 0.0) & (d < reach)) if uneven > 0.0 else np.empty(0, np.int64)
    if not near.size:
        return None, np.empty((3, 0))
    metres = value[7, near]
    most = min(float(OCTAVES[1]), 29.0 + np.log2(step_m))
    x = np.clip(np.log2(metres / MEANDER_SHARE), OCTAVES[0], most)
    low = np.minimum(np.floor(x), most - 1.0)
    octave = np.stack([low, low + 1.0])
    at = bent[:, None, near] * np.exp2(-octave) + octave_offsets(octave)
    found = Wander(near, octave, Lattice(np.ones(2), np.zeros((2, 3))).cells(at), metres, x - low)
    n = found.corners.vector()
    mixed = n[:, 0] + found.share * (n[:, 1] - n[:, 0])
    moved = wander_slopes(d[near], value[1, near], metres)[0]
    return found, bent[:, near] + moved * mixed


def wander_by_place(found: Wander, d: Floats, value: Floats, steps: Floats, away: Floats, along: Floats) -> Floats:
    """(3, 3, Q): how the place that is moved changes [a] with the bent one [b]. d, away: from the valley's line."""
    near = found.near
    value, steps, along = value[:, near], steps[:, near], along[:, near]
    n, slope = found.corners.vector_derivative()
    share = found.share
    mixed, more = n[:, 0] + share * (n[:, 1] - n[:, 0]), n[:, 1] - n[:, 0]
    scale = np.exp2(-found.octave)
    turned = slope[:, :, 0] * scale[0] * (1.0 - share) + slope[:, :, 1] * scale[1] * share
    moved, by_d, by_half, by_metres = wander_slopes(d[near], value[1], found.metres)
    # The share of the longer octave is the logarithm of metres, where that is not at its bounds.
    by_share = np.where((share > 0.0) & (share < 1.0), moved / (found.metres * np.log(2.0)), 0.0)
    by_place = by_d * away[:, near] + (by_half * steps[1] + by_metres * steps[7]) * along
    result = moved * turned + mixed[:, None] * by_place + (more * by_share)[:, None] * (steps[7] * along)
    for axis in range(3):
        result[axis, axis] += 1.0
    return result
