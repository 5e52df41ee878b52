"""How far valleys of rivers let ground rise above the line between two places of a ray, float64.

Above a river the ground is C = base + open (h - base) of the uncarved ground h, below it h itself, which is never above
C's formula there: C is the least of the two, so it is enough to bound the one that holds at both ends. Of a product of
two functions that leave the lines between their ends by e_f and e_g at most, with the ends' differences f' and g', the
product leaves its own by (f + e_f) e_g + g e_f - f' g' / 4. So C rises by what h does and

    |h - base| e_open + e_base - open' (h - base)' / 4

e_open and e_base: see rivers/steepness.py. Where water's edges may lie on the way, e_base has the slope of the steepest
banks. Above themselves rivers only cut: C rises by no more than the most that they have cut at an end. Ground that dips
below a river and is raised there, to the river at most, has the slope of the planet's steepest valleys.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .height_octaves import STEEPEST_BANK
from .rivers.steepness import Steepness

__all__ = ["Cut", "valley_rise"]

Floats = NDArray[np.float64]

_DRY_WAY = 0.5
"""Stretches at most so long by the distance of their ends from the water's edge don't meet it: no place between is
further from both than half of that, and the warp stretches distances twice at most."""


@dataclass(frozen=True)
class Cut:
    """Places (N,) where stretches end."""

    above_m: Floats
    """Height of the uncarved ground above the river's own; below it negative."""
    base_m: Floats
    """The river's own ground."""
    open: Floats
    cut_m: Floats
    """How far rivers have moved the ground."""
    steep: Floats
    """(10, N): see Steepness."""

    def at(self, which: NDArray[np.int64]) -> Cut:
        """Some of them."""
        above_m, base_m, left, cut_m = (v.take(which) for v in (self.above_m, self.base_m, self.open, self.cut_m))
        return Cut(above_m, base_m, left, cut_m, self.steep.take(which, axis=1))


def valley_rise(a: Cut, b: Cut, length_m: Floats, rise: Floats, steepest_per_m: float) -> Floats:
    """(N,) of stretches of length_m (N,) whose uncarved ground rises by `rise` (N,). steepest_per_m: of the planet's
    valleys."""
    line_a, line_b = a.steep[Steepness.LINE], b.steep[Steepness.LINE]
    out_a, out_b = line_a < 0.0, line_b < 0.0
    # Outside of valleys there is no base: the other end's goes on.
    above_a = np.where(out_a, a.above_m + a.base_m - b.base_m, a.above_m)
    above_b = np.where(out_b, b.above_m + b.base_m - a.base_m, b.above_m)
    worst = np.maximum(a.steep, b.steep)
    turned = length_m * worst[Steepness.BEND]
    half_m = 0.5 * length_m
    eighth = 0.125 * length_m * length_m
    one = 0.125 * length_m * turned + np.minimum(half_m * worst[Steepness.KINK], eighth * worst[Steepness.KINK_BEND])
    several = half_m * (worst[Steepness.SIDE] + 0.5 * turned)
    e_open = np.minimum(np.where((line_a == line_b) | out_a | out_b, one, several), 1.0)

    wet = length_m * worst[Steepness.EDGE] > _DRY_WAY
    e_base = half_m * (worst[Steepness.FLOOR] + np.where(wet, STEEPEST_BANK, worst[Steepness.BANK]))
    e_base = np.where(wet, e_base, np.minimum(e_base, eighth * worst[Steepness.FLOOR_BEND]))
    most = np.maximum(np.abs(above_a), np.abs(above_b)) + rise
    twisted = np.maximum((a.open - b.open) * (above_b - above_a), 0.0)
    # An end below the river lies under the formula for ground above it.
    under = np.maximum((1.0 - a.open) * np.maximum(-above_a, 0.0), (1.0 - b.open) * np.maximum(-above_b, 0.0))
    more = most * e_open + e_base + 0.25 * twisted + under
    least = np.minimum(above_a, above_b)
    held = ((worst[Steepness.HELD] > 0.0) | wet) & (least < rise + e_base)
    more = np.where(held, np.maximum(more, half_m * (steepest_per_m * most + STEEPEST_BANK)), more)
    cut_m = np.maximum(a.cut_m, b.cut_m)
    return np.minimum(np.where(held, np.maximum(cut_m, rise - least), cut_m), more)
