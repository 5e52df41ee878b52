"""How fast valleys may change the ground about places: what a ray has to know of them (ray_ground.py).

A valley's side is a parabola of the distance from its line, and that distance is convex along a straight way. So
`open`, the share of the ground's height above the river that is left, rises above the line between two places by no
more than its bend allows, as long as one river line says it at both: where another says less on the way, ground is
lower still.

The river's own ground falls with its line, rises from the water's edge the less the further that is, and changes
between lines with different levels. These slopes are those at the place; they count `MARGIN` times, for the warp that
bends lines and for what changes on a way of half the distance from the water.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from .form import BANK_FAR, BANK_M, BANK_SHARE, FLOOR_SLOPE, NEAR_M2, river_open, river_section, river_share
from .pairs import Pairs, chosen
from .table import RiverTable
from .valleys import Valleys

__all__ = ["MARGIN", "Steepness", "steepness"]

Floats = NDArray[np.float64]

MARGIN = 2.0
"""The warp stretches distances by 1.9 at most, by 1.6 on all but one of a hundred places."""
UNEVEN = 2.2
"""Noise makes a bank turn by so much: three octaves that change by 0.3 of a way each, and what fades further out."""
UNEVEN_BEND, UNEVEN_BEND_PER_M = 8.0, 0.15
"""How fast that changes: by the half width where it fades, and 0.3 by wavelengths from 16 m on where it is noise."""
_VALUE_BEND = 10.0 / np.sqrt(3.0) * 2.0
"""The largest second derivative of value noise between -1 and 1 along an axis, by the lattice coordinate: the quintic's
times the step between corners."""


class Steepness(IntEnum):
    """Rows of `steepness`. What bends makes the ground rise over D metres by D^2 / 8 times that."""

    LINE = 0
    """Number of the line that says `open`, -1 outside of valleys."""
    BEND = 1
    """Of `open`, where it bends down: 1/m2."""
    SIDE = 2
    """Slope of `open`, 1/m."""
    KINK = 3
    """By how much that may change at an end of the line."""
    KINK_BEND = 4
    """The same as a bend, for ends come into reach of D as that grows."""
    FLOOR = 5
    """Slope of the river's own ground, but for banks and beds."""
    FLOOR_BEND = 6
    """How that bends, with banks, 1/m."""
    BANK = 7
    """Slope of banks and beds."""
    EDGE = 8
    """Inverse of the distance from the nearest water's edge, 1/m."""
    HELD = 9
    """1 where ground below the river is raised."""


def steepness(found: Valleys, table: RiverTable) -> Floats:
    """(10, N) at the places of `found`: see Steepness; none negative but LINE, and 0 where no valley reaches."""
    result = np.zeros((len(Steepness), len(found.base_m)))
    result[Steepness.LINE] = -1.0
    pairs = found.pairs
    if pairs is None:
        return result
    at, first = pairs.near, pairs.first
    half, depth = pairs.bank, pairs.value[2]
    heard, beyond = pairs.d < pairs.value[4], np.maximum(pairs.d - half, 0.0)

    def largest(values: Floats) -> Floats:
        return np.maximum.reduceat(np.where(heard, values, 0.0), first)

    _sides(result, found, pairs, table)
    uneven = np.where(_uneven(pairs), 1.0 + UNEVEN * table.uneven, 1.0)
    # The bank a / (4 x) is the steepest of all a k / (k + x)^2, k: half width and two metres. The bed is a parabola.
    bank = (BANK_M + BANK_SHARE * depth) * np.minimum(1.0 / (half + 2.0), 0.25 / np.maximum(beyond, 1e-9))
    bed = np.where(pairs.d < half, 2.0 * depth / (half + 1e-3), 0.0)
    banks = uneven * (bank + bed)
    result[Steepness.BANK, at] = MARGIN * largest(banks)
    result[Steepness.EDGE, at] = largest(uneven / np.maximum(np.abs(pairs.d - half), 1e-9))
    result[Steepness.HELD, at] = found.raised[at] > 0.0
    _floors(result, found, pairs, banks, table.uneven)
    return result


def _sides(result: Floats, found: Valleys, pairs: Pairs, table: RiverTable) -> None:
    """Fills the rows of `open`."""
    _, _, _, floor, reach, _ = pairs.value[:6]
    at, left = pairs.near, found.open[pairs.near]
    k = chosen(river_open(pairs.d, floor, reach), left, pairs)
    inside = left < 1.0
    width = reach[k] - floor[k]
    side, change = 2.0 / width, np.abs(pairs.steps[3:5, k]).sum(axis=0) / pairs.length_m[k]
    result[Steepness.LINE, at] = np.where(inside, pairs.line[k], -1.0)
    bend = side / width * MARGIN**2 * (1.0 + 2.0 * change) + side * _bend_per_m(table)
    result[Steepness.BEND, at] = inside * bend
    kink = inside * MARGIN * side * change
    result[Steepness.KINK, at] = kink
    # No end is in reach of D while that is less than half of the distance from it.
    result[Steepness.KINK_BEND, at] = kink * 8.0 / np.maximum(pairs.end_m[k], 1e-9)
    # With v the share of the side's width, open = v (2 - v).
    result[Steepness.SIDE, at] = MARGIN * side * np.sqrt(np.maximum(1.0 - left, 0.0)) + kink


def _uneven(pairs: Pairs) -> NDArray[np.bool_]:
    """(P,) where noise moves banks."""
    return pairs.d < BANK_FAR * pairs.value[1]


def _floors(result: Floats, found: Valleys, pairs: Pairs, banks: Floats, uneven: float) -> None:
    """Fills FLOOR and FLOOR_BEND. banks (P,): slopes of each line's own bank and bed. uneven: how much."""
    level, straight, depth, _, reach = pairs.value[:5]
    d, half, first, at = pairs.d, pairs.bank, pairs.first, pairs.near
    share, beyond = river_share(d, straight, reach), np.maximum(d - straight, 0.0)
    total = np.add.reduceat(share, first)
    share = np.divide(share, np.repeat(total, pairs.many), out=np.zeros_like(share), where=share > 0.0)

    def mean(values: Floats) -> Floats:
        return np.add.reduceat(share * values, first)

    # What a line has to say changes as fast, by what it says: left^2 / (beyond^2 + NEAR_M2).
    turns = 2.0 / np.maximum(reach - d, 1e-9) + 2.0 * beyond / (beyond * beyond + NEAR_M2)
    apart = np.abs(level + river_section(d, half, depth) - np.repeat(found.base_m[at], pairs.many))
    falls = np.abs(pairs.steps[0]) / pairs.length_m
    mixed, fall = apart * turns, falls + banks
    result[Steepness.FLOOR, at] = MARGIN * (mean(mixed + falls) + FLOOR_SLOPE)
    # One line alone does not bend but at its ends; of several those say more that differ from the mean.
    others = np.maximum(fall * (1.0 - 2.0 * share) + np.repeat(mean(fall), pairs.many), 0.0)
    bends = 1.5 * mixed * turns + 2.0 * turns * others + 8.0 * falls / np.maximum(pairs.end_m, 1e-9)
    bends += 2.0 * banks / np.maximum(d - half, 1e-9)
    # Where noise moves banks, and that fades with the distance.
    curls = np.where(_uneven(pairs), UNEVEN_BEND_PER_M + UNEVEN_BEND / np.maximum(half, 1e-9), 0.0)
    bends += uneven * banks * curls
    result[Steepness.FLOOR_BEND, at] = MARGIN * mean(bends)


def _bend_per_m(table: RiverTable) -> float:
    """How fast, at most, a straight way turns where the warp moves it, 1/m."""
    return float((table.bend_m * table.bends.frequency**2).sum()) * _VALUE_BEND * np.sqrt(3.0)
