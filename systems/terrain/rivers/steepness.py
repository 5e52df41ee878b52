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

from .form import BANK_M, BANK_SHARE, FLOOR_SLOPE, LAKE_NEAR_M2, NEAR_M2, river_open, river_section, river_share
from .pairs import chosen
from .table import RiverTable
from .valleys import Valleys

__all__ = ["MARGIN", "Steepness", "steepness"]

Floats = NDArray[np.float64]

MARGIN = 2.0
"""The warp stretches distances by 1.9 at most, by 1.6 on all but one of a hundred places."""
_VALUE_BEND = 10.0 / np.sqrt(3.0) * 2.0
"""The largest second derivative of value noise between -1 and 1 along an axis, by the lattice coordinate: the quintic's
times the step between corners."""


class Steepness(IntEnum):
    """Rows of `steepness`."""

    LINE = 0
    """Number of the line that says `open`, -1 outside of valleys."""
    BEND = 1
    """Of `open`, where it bends down: 1/m2."""
    SIDE = 2
    """Slope of `open`, 1/m."""
    KINK = 3
    """By how much that may change at an end of the line."""
    FLOOR = 4
    """Slope of the river's own ground, but for banks and beds."""
    BANK = 5
    """Slope of these."""
    BANK_M = 6
    """Metres from the bed to where the bank ends."""
    EDGE = 7
    """Inverse of the distance from the nearest water's edge, 1/m."""
    HELD = 8
    """1 where ground below the river is raised."""


def steepness(found: Valleys, table: RiverTable) -> Floats:
    """(9, N) at the places of `found`: see Steepness; none negative but LINE, and 0 where no valley reaches."""
    result = np.zeros((len(Steepness), len(found.base_m)))
    result[Steepness.LINE] = -1.0
    pairs = found.pairs
    if pairs is None:
        return result
    level, half, depth, floor, reach, lake = pairs.value[:6]
    s_level, _, _, s_floor, s_reach = pairs.steps[:5]
    at, first, d, many = pairs.near, pairs.first, pairs.d, pairs.many
    heard, by_line = d < reach, 1.0 / pairs.length_m

    left = found.open[at]
    k = chosen(river_open(d, floor, reach), left, pairs)
    inside = left < 1.0
    width = reach[k] - floor[k]
    side = 2.0 / width
    result[Steepness.LINE, at] = np.where(inside, pairs.line[k], -1.0)
    result[Steepness.BEND, at] = inside * (side / width * MARGIN**2 + side * _bend_per_m(table))
    kink = side * (np.abs(s_floor[k]) + np.abs(s_reach[k])) * by_line[k]
    result[Steepness.KINK, at] = inside * MARGIN * kink
    # With v the share of the side's width, open = v (2 - v).
    result[Steepness.SIDE, at] = MARGIN * (side * np.sqrt(np.maximum(1.0 - left, 0.0)) + inside * kink)

    # What a line has to say changes as fast, by what it says: left^2 / (beyond^2 + near).
    near = NEAR_M2 + (LAKE_NEAR_M2 - NEAR_M2) * lake
    share, beyond = river_share(d, half, reach, near), np.maximum(d - half, 0.0)
    turns = 2.0 / np.maximum(reach - d, 1e-9) + 2.0 * beyond / (beyond * beyond + near)
    apart = np.abs(level + river_section(d, half, depth) - np.repeat(found.base_m[at], many))
    total = np.add.reduceat(share, first)
    mixed = np.add.reduceat(share * apart * turns, first)
    mixed = np.divide(mixed, total, out=np.zeros_like(total), where=total > 0.0)
    # The bank a / (4 x) is the steepest of all a k / (k + x)^2, k: half width and two metres. The bed is a parabola.
    bank = (BANK_M + BANK_SHARE * depth) * np.minimum(1.0 / (half + 2.0), 0.25 / np.maximum(beyond, 1e-9))
    bed = np.where(d < half, 2.0 * depth / (half + 1e-3), 0.0)

    def largest(values: Floats) -> Floats:
        return np.maximum.reduceat(np.where(heard, values, 0.0), first)

    result[Steepness.FLOOR, at] = MARGIN * (largest(np.abs(s_level) * by_line) + FLOOR_SLOPE + mixed)
    result[Steepness.BANK, at] = MARGIN * largest(bank + bed)
    result[Steepness.BANK_M, at] = largest(BANK_M + (1.0 + BANK_SHARE) * depth)
    result[Steepness.EDGE, at] = largest(1.0 / np.maximum(np.abs(d - half), 1e-9))
    result[Steepness.HELD, at] = found.raised[at] > 0.0
    return result


def _bend_per_m(table: RiverTable) -> float:
    """How fast, at most, a straight way turns where the warp moves it, 1/m."""
    return float((table.bend_m * table.bends.frequency**2).sum()) * _VALUE_BEND * np.sqrt(3.0)
