"""Craters along stretches of rays, float64: found once per octave and stretch, handed on to its halves.

A stretch is asked for octaves whose cells are at least as wide as it is long; then the 27 cells around its middle hold
all craters that reach it. Each is kept with its distances, in its own radii, from both ends of the stretch, which bound
those between them: along the way the profile can rise above the line between its two ends by no more than its concave
parts allow.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...engine.compiled import Kernels
from .crater_form import CraterShape, crater_rise, crater_sizes
from .craters import SHIFTS, STEPS, TEN_BITS, Craters, draws, mixed

__all__ = ["CraterPaths", "found_along", "rest_m"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_COMPILED = Kernels(__package__, "crater_path_kernels")

REACH = 2.0
"""Ejecta end at so many radii."""
_CREST = 0.25 * 0.85
"""A crest by its cell's width over its shape's rim: the largest radius; the rim of a fresh one after its rounding."""
_BOWL = 0.25


@dataclass
class CraterPaths:
    """Craters by stretch, octave and age."""

    names: Ints
    """(3, C): stretch, octave, age"""
    numbers: Floats
    """(11, C): the columns below, in their order"""

    @classmethod
    def none(cls) -> CraterPaths:
        return cls(np.zeros((3, 0), np.int64), np.zeros((11, 0)))

    @property
    def stretch(self) -> Ints:
        return self.names[0]

    @property
    def octave(self) -> Ints:
        return self.names[1]

    @property
    def age(self) -> Ints:
        return self.names[2]

    @property
    def centre(self) -> Floats:
        """(3, C): the foot of its axis on the sphere, metres"""
        return self.numbers[:3]

    @property
    def inverse_radius(self) -> Floats:
        """1/m"""
        return self.numbers[3]

    @property
    def relief_m(self) -> Floats:
        """Radius times freshness: what the profile is multiplied with."""
        return self.numbers[4]

    @property
    def fresh(self) -> Floats:
        return self.numbers[5]

    @property
    def kept(self) -> Floats:
        return self.numbers[6]

    @property
    def a(self) -> Floats:
        """Distance of the stretch's first end from the axis by the crater's radius."""
        return self.numbers[7]

    @property
    def b(self) -> Floats:
        return self.numbers[8]

    @property
    def height_a(self) -> Floats:
        """Metres at that end."""
        return self.numbers[9]

    @property
    def height_b(self) -> Floats:
        return self.numbers[10]

    def __len__(self) -> int:
        return self.names.shape[1]

    def take(self, which: Ints) -> CraterPaths:
        return CraterPaths(self.names.take(which, axis=1), self.numbers.take(which, axis=1))

    def renumbered(self, number: Ints) -> CraterPaths:
        """Those of stretches whose `number` (S,) is not negative, which it is from then on."""
        if (compiled := _COMPILED()) is not None:
            return CraterPaths(*compiled.kept((self.names, self.numbers), number))
        stretch = number[self.stretch]
        found = self.take(np.flatnonzero(stretch >= 0))
        found.stretch[:] = stretch[stretch >= 0]
        return found

    def joined(self, other: CraterPaths) -> CraterPaths:
        """Both, by stretch, octave and age."""
        if not len(self) or not len(other):
            return other if len(other) else self
        if (compiled := _COMPILED()) is not None:
            return CraterPaths(*compiled.joined((self.names, self.numbers), (other.names, other.numbers)))
        return CraterPaths(
            np.concatenate([self.names, other.names], axis=1), np.concatenate([self.numbers, other.numbers], axis=1)
        ).sorted()

    def sorted(self) -> CraterPaths:
        return self.take(np.argsort((self.stretch * 32 + self.octave) * 8 + self.age, kind="stable"))

    def heights(self, craters: Craters, away: Floats) -> tuple[Floats, Floats]:
        """Of each crater alone (C,) at distances `away` (C,) in radii, and how much of what is older it wipes out."""
        shape = CraterShape(*craters.shape[self.octave].T)
        form, covered = crater_rise(shape, away * away, self.kept, self.fresh)
        return self.relief_m * form, covered

    def sums(self, heights: Floats, covers: Floats, stretches: int) -> Floats:
        """What all craters of each stretch add (S,), by `heights`: the younger of an octave wipe out the older."""
        if not len(self):
            return np.zeros(stretches)
        group, rank = self._groups()
        first = rank == 0
        total = np.where(first, heights, 0.0)[first]
        for k in range(1, int(rank.max()) + 1):
            at = np.flatnonzero(rank == k)
            total[group[at]] = total[group[at]] * (1.0 - covers[at]) + heights[at]
        return np.bincount(self.stretch[first], total, stretches).astype(np.float64)

    def _groups(self) -> tuple[Ints, Ints]:
        """The number of the stretch and octave that each crater belongs to, and its place by age among these."""
        key = self.stretch * 32 + self.octave
        new = np.empty(len(key), bool)
        new[0], new[1:] = True, key[1:] != key[:-1]
        group = np.cumsum(new) - 1
        return group, np.arange(len(key)) - np.flatnonzero(new)[group]

    def rise(self, craters: Craters, length_m: Floats) -> Floats:
        """How far (S,) ground may rise above the line between its two ends along stretches of `length_m` (S,), by
        craters that are listed here."""
        if not len(self):
            return np.zeros(len(length_m))
        if (compiled := _COMPILED()) is not None:
            return compiled.rise(craters, (self.names, self.numbers), length_m)
        wall, _floor, rim, peak = craters.shape[self.octave].T
        d = length_m[self.stretch] * self.inverse_radius
        low = np.maximum(0.5 * (self.a + self.b - d), 0.0)
        high = 0.5 * (self.a + self.b + d)
        low *= low
        high *= high
        # The polynomial minimum of wall and ejecta is concave where it rounds the crest: |q - 1| < width / wall.
        width = rim * (2.2 - 1.6 * self.fresh)
        around = width / wall
        crest = (low < 1.0 + around) & (high > 1.0 - around)
        ejecta = (4.0 - np.maximum(low, 1.0 - around)) * (1.0 / 3.0)
        ejecta = np.where(high > 1.0 - around, np.maximum(ejecta, 0.0), 0.0)
        falls = rim * ejecta * ejecta  # largest -dh/dq beyond the crest
        # The Hessian of h(q), q = |x|^2 / R^2, is 4 q h'' along the radius, plus 2 h' in all directions.
        bend = 2.0 * falls + np.where(low < 1.0 / 12.0, 48.0 * peak, 0.0)
        sharpest = (wall + rim * 1.3) ** 2 / (2.0 * width)
        bend += np.where(crest, 4.0 * np.minimum(high, 1.0 + around) * sharpest, 0.0)
        rise = bend * d * d * 0.125
        # A tent of these slopes stands above its base by no more than this; nor is anything higher than the rim.
        steep = np.sqrt(np.minimum(high, 1.0 + around)) * 2.0 * (wall + falls)
        steep += np.where(low < 1.0 / 12.0, 24.0 * peak, 0.0)
        rise = np.minimum(rise, np.where(crest | (low < 1.0 / 12.0), 0.25 * steep * d, np.inf))
        rise *= self.relief_m
        top = np.where(high > 1.0 - around, rim, rim + wall * (high - 1.0))
        ends = np.minimum(self.height_a, self.height_b)
        highest = np.maximum(np.maximum(top * self.relief_m, self.height_a), self.height_b)
        rise = np.minimum(rise, np.where(low < 1.0 / 12.0, np.inf, highest - ends))
        group, rank = self._groups()
        if (rank > 0).any():
            # Where a younger one ends on an older one, that comes back by as much as the cover changes.
            several = np.flatnonzero((np.bincount(group)[group] > 1) & (rank > 0))
            changes = np.minimum(1.5 * (np.minimum(high[several], 1.5) - np.maximum(low[several], 0.5)), 1.0)
            changes = np.maximum(changes, 0.0) * self.kept[several]
            size = np.maximum(np.abs(self.height_a), np.abs(self.height_b)) + 0.5 * steep * d * self.relief_m
            size = np.minimum(size, (wall + rim) * self.relief_m)
            rise[several] += changes * (np.bincount(group, size)[group[several]] - size[several])
        return np.bincount(self.stretch, rise, len(length_m)).astype(np.float64)

    def halves(self, craters: Craters, middle: Floats, length_m: Floats, stretches: int) -> tuple[CraterPaths, Floats]:
        """The craters of both halves of each stretch, numbered 2 s and 2 s + 1, and what they add to the height at the
        middle (S,). middle: (3, S) on the sphere, m; length_m (S,): of the halves."""
        if (compiled := _COMPILED()) is not None:
            lists, added = compiled.halves(craters, (self.names, self.numbers), middle, length_m)
            return CraterPaths(*lists), added
        away = np.sqrt(((middle[:, self.stretch] - self.centre) ** 2).sum(axis=0)) * self.inverse_radius
        height, covers = self.heights(craters, away)
        added = self.sums(height, covers, stretches)
        d = length_m[self.stretch] * self.inverse_radius
        parts = []
        for side, (a, b) in enumerate(((self.a, away), (away, self.b))):
            near = np.flatnonzero(0.5 * (a + b - d) < REACH)
            part = self.take(near)
            part.names[0] = 2 * part.stretch + side
            first = 8 - side  # columns of the end in the middle
            part.numbers[first], part.numbers[first + 2] = away[near], height[near]
            parts.append(part)
        return parts[0].joined(parts[1]), added


class _Cells(NamedTuple):
    """Craters by cells, arrays (C,)."""

    stretch: Ints
    octave: Ints
    age: Ints
    wide: Floats
    worn: Floats
    """Draws in [0, 1)."""
    place_m: Floats
    """(3, C)"""


def found_along(
    craters: Craters, octaves: Ints, ends: tuple[Floats, Floats], length_m: Floats
) -> tuple[CraterPaths, Floats, Floats]:
    """Craters of `octaves`, which follow one another, along stretches between places `ends` (3, S) on the sphere,
    `length_m` (S,) long at most; and what they add to the heights at both ends (S,). Cells have to be as wide as the
    stretches are long."""
    count, radius = len(length_m), craters.radius_m
    if (compiled := _COMPILED()) is not None and count and len(octaves):
        lists, *sums = compiled.found(craters, int(octaves[0]), int(octaves[-1]) + 1, ends, length_m)
        return CraterPaths(*lists), *sums
    middle = 0.5 * (ends[0] + ends[1])
    middle *= radius / np.sqrt((middle * middle).sum(axis=0))
    stretch, octave = np.repeat(np.arange(count), len(octaves)), np.tile(octaves, count)
    blocks = range(0, len(stretch), _TOGETHER)
    parts = [_cells(craters, octave[b : b + _TOGETHER], stretch[b : b + _TOGETHER], middle, length_m) for b in blocks]
    s, k, age = (
        np.concatenate(p) for p in ([p.stretch for p in parts], [p.octave for p in parts], [p.age for p in parts])
    )
    wide, worn = np.concatenate([p.wide for p in parts]), np.concatenate([p.worn for p in parts])
    place = np.concatenate([p.place_m for p in parts], axis=1)
    away = np.sqrt((place * place).sum(axis=0))
    frequency = craters.frequency[k]
    kept, _, room, smaller, fresh = crater_sizes((away - radius) * frequency, away * (1.0 / radius), 1.0, wide, worn)
    inverse = np.sqrt(smaller / room) * frequency
    centre = place * (radius / away)
    a, b = (np.sqrt(((end[:, s] - centre) ** 2).sum(axis=0)) * inverse for end in ends)
    numbers = np.stack([*centre, inverse, fresh / inverse, fresh, kept, a, b, a, b])
    found = CraterPaths(np.stack([s, k, age]), numbers)
    found = found.take(np.flatnonzero((kept > 0.0) & (0.5 * (a + b - length_m[s] * inverse) < REACH))).sorted()
    found.numbers[9], cover_a = found.heights(craters, found.a)
    found.numbers[10], cover_b = found.heights(craters, found.b)
    return found, found.sums(found.height_a, cover_a, count), found.sums(found.height_b, cover_b, count)


def _cells(craters: Craters, octave: Ints, stretch: Ints, middle: Floats, length_m: Floats) -> _Cells:
    """Craters whose places are near enough to touch the stretches."""
    frequency, offset = craters.frequency[octave], craters.offset[octave].T
    at = middle[:, stretch] * frequency + offset
    cell = np.floor(at)
    at -= cell
    reach = (0.5 + 0.5 * length_m[stretch] * frequency) ** 2
    # How far the cells beside and the own one are along each axis.
    gaps = np.stack([at * at, np.zeros_like(at), (1.0 - at) ** 2])
    near = gaps[:, None, None, 2] + gaps[None, :, None, 1] + gaps[None, None, :, 0] < reach
    z, y, x, n = np.nonzero(near)
    beside = np.stack([x, y, z]) - 1
    low = (cell[:, n].astype(np.int64) + beside).astype(np.uint32)
    word = mixed(low[0] * STEPS[0] + low[1] * STEPS[1] + low[2] * STEPS[2])
    inside = ((word >> SHIFTS[:3, None] & TEN_BITS) + 0.5) * (1.0 / 1024.0)
    away = at[:, n] - beside - inside
    draw, wide, worn = draws(word)
    there = ((away * away).sum(axis=0) < reach[n]) & (draw < craters.accept)
    n = n[there]
    odd = low[:, there] & 1
    place = (cell[:, n] + beside[:, there] + inside[:, there] - offset[:, n]) / frequency[n]
    age = (odd[0] + 2 * odd[1] + 4 * odd[2]).astype(np.int64)
    return _Cells(stretch[n], octave[n], age, wide[there], worn[there], place)


_TOGETHER = 4000


def rest_m(craters: Craters, octaves: int) -> tuple[float, float]:
    """How much craters of the octaves from `octaves` on may raise the ground, and lower it: as much as the largest and
    freshest crests of all octaves at one place, and the deepest bowls."""
    width = 1.0 / craters.frequency[octaves:]
    _wall, floor, rim, _peak = craters.shape[octaves:].T
    return float((_CREST * rim * width).sum()), float((_BOWL * (floor - rim) * width).sum())
