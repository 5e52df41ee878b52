"""Heights of real elevation, float64: levels of pages over one another, the finest first. Twin of
assets/shaders/terrain/real_ground.glsl.

Each level stands in with its weight for what the finer ones leave, and what all of them leave is the ground around:

    height = sum_k s_k R_k prod_{i<k} (1 - s_i)  +  rest P,    rest = prod (1 - s_i)

R: the cubic through a level's heights, limited (limited_cubic.py). s: the cubic B-spline through its weights, which
are 1 at samples and around them. Gradients as a spacing shows them leave out levels whose samples are finer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .lattice import Lattice, sphere_place
from .limited_cubic import limited_cubic
from .pages import BEFORE, ROUGH_SIDE, STEEP_SIDE, PageLevel

__all__ = [
    "DONE",
    "LEVEL_SAMPLES",
    "MOST_ROUGH",
    "Composed",
    "RealGround",
    "Relief",
    "World",
    "level_share",
    "sample_level",
]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

LEVEL_SAMPLES = 1.5
"""Gradients come from levels whose samples are this many spacings apart, or more."""
_STEEPER = 2.0
"""Than between samples: the limited cubic's slope in the middle of a step is 1.5, at its ends up to 2.1 of the smaller
one, and levels pass into one another."""
MOST_ROUGH = 1.2
"""Relief is not made rougher: vertices hand on up to 1.3."""
DONE = 1e-7
"""A rest below that is none."""


@dataclass(frozen=True)
class Composed:
    """What the levels make of N places: metres (N,) to which `rest` (N,) of the ground around is added; and of the
    ground that a spacing shows the gradient (3, N) of these metres by the points, and the rest of it (N,) with its own.
    """

    height_m: Floats
    rest: Floats
    d_height: Floats
    seen_rest: Floats
    d_rest: Floats
    relief: Relief


@dataclass(frozen=True)
class Relief:
    """The relief below the samples at N places: its roughness (N,), the gradient (3, N) of that, or zeros, and the
    distance (N,) of the samples below which it begins, metres."""

    rough: Floats
    d_rough: Floats
    sample_m: Floats
    falls: Floats | None = None
    """(3, N), where asked for: the slope of the B-spline through the samples, smoother than the ground's own, which
    gullies follow"""
    d_falls: Floats | None = None
    """(3, 3, N): how that [a] changes with the place [b], where gradients were asked for"""


def _relief(rough: Floats, d_rough: Floats, deep: Floats, rest: Floats, falls: Floats | None) -> Relief:
    """falls (12, N): the slope and its derivatives, times what levels stand in for."""
    with np.errstate(invalid="ignore", divide="ignore"):
        sample_m = np.exp2(np.where(rough > 0.0, deep / rough, 0.0))
    if falls is None:
        return Relief(rough, d_rough, sample_m)
    falls = falls / np.maximum(1.0 - rest, DONE)
    return Relief(rough, d_rough, sample_m, falls[:3], falls[3:].reshape(3, 3, -1))


def level_share(sample_m: float, spacing_m: Floats, factor: float) -> Floats:
    """How much (N,) of a level's gradient is seen where samples are spacing_m apart; factor: how many times finer it
    is than the next level of its set."""
    finer = np.log(np.maximum(LEVEL_SAMPLES * spacing_m / sample_m, 1e-9)) / np.log(factor)
    return np.clip(1.0 - finer, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class RealGround:
    """Levels, the finest first; factors: how many times finer each is than the next one of its set, 0 for the coarsest.
    Equal only to itself.

    finest_of: of each level the finest one of its set. lowest_m, highest_m: of all samples, with room for the cubic
    between them.
    """

    levels: tuple[PageLevel, ...]
    factors: tuple[int, ...]
    finest_of: tuple[int, ...]
    lowest_m: float
    highest_m: float

    def heights(self, points: Floats) -> tuple[Floats, Floats]:
        """Metres (N,) at points (3, N), and the rest (N,) of the ground around that is added to them."""
        return self.compose(points, None, 1.0)[:2]

    def compose(
        self,
        points: Floats,
        rough_by: Sequence[float] | None,
        radius_m: float,
        slopes: bool = False,
        follow: bool = False,
    ) -> tuple[Floats, Floats, Relief | None]:
        """As heights, and the relief below the samples. rough_by: of each level, what makes of metres that its samples
        differ by a roughness. slopes: with the gradient of that, as if levels didn't pass into one another. follow:
        with the slopes that gullies follow, likewise."""
        world, count = World(points), points.shape[1]
        height, rest = np.zeros(count), np.ones(count)
        rough, deep, d_rough = np.zeros(count), np.zeros(count), np.zeros((3, count))
        falls = np.zeros((12, count)) if follow and rough_by is not None else None
        for number, level in enumerate(self.levels):
            at = np.flatnonzero(rest > 0.0)
            if not at.size:
                break
            found = sample_level(level, world, at)
            if found is None:
                continue
            at = at[found.at]
            share = rest[at] * found.weight
            height[at] += share * found.height
            if rough_by is not None:
                metres, d_metres = found.roughness(level, slopes)
                steep = rough_by[number] * metres
                below = steep < MOST_ROUGH
                rough[at] += share * np.where(below, steep, MOST_ROUGH)
                deep[at] += share * np.where(below, steep, MOST_ROUGH) * np.log2(level.lattice.sample_m(radius_m))
                to_points = world.jacobian(level.lattice, at) if slopes or falls is not None else None
                if slopes and to_points is not None:
                    d_metres = _chain(d_metres * rough_by[number], to_points)
                    d_rough[:, at] += share * np.where(below, d_metres, 0.0)
                if falls is not None and to_points is not None:
                    falls[:, at] += share * found.falls(to_points, slopes)
            rest[at] *= 1.0 - found.weight
            rest[rest < DONE] = 0.0
        return height, rest, None if rough_by is None else _relief(rough, d_rough, deep, rest, falls)

    def slopes(self, points: Floats, radius_m: float) -> Floats:
        """Slopes (N,) that the levels at points (3, N), and their passing into one another, hardly ever exceed."""
        world = World(points)
        steep, rest = np.zeros(points.shape[1]), np.ones(points.shape[1])
        for level in self.levels:
            at = np.flatnonzero(rest > 0.0)
            if not at.size:
                break
            found = sample_level(level, world, at)
            if found is None:
                continue
            at = at[found.at]
            steepest = _STEEPER * level.steep_at(found.block, radius_m)
            steep[at] = np.maximum(steep[at], steepest)
            rest[at] *= 1.0 - found.weight
            rest[rest < DONE] = 0.0
        return steep

    def finest_m(self, radius_m: float) -> float:
        """Distance of the finest samples."""
        return self.levels[0].lattice.sample_m(radius_m)

    def steepest(self, radius_m: float) -> float:
        """The largest of these."""
        return _STEEPER * max(level.steepest(radius_m) for level in self.levels)

    def gradients(
        self,
        points: Floats,
        radius_m: float,
        spacing_m: Floats | None,
        rough_by: Sequence[float] | None = None,
        follow: bool = False,
    ) -> Composed:
        """As compose, with gradients that samples spacing_m (N,) apart show: None, all."""
        world, count = World(points), points.shape[1]
        height, rest, relief = self.compose(points, rough_by, radius_m, slopes=True, follow=follow)
        kept = np.ones(count)
        d_seen, d_kept = np.zeros((3, count)), np.zeros((3, count))
        for level, factor in zip(self.levels, self.factors, strict=True):
            share = np.ones(count)
            if spacing_m is not None and factor:
                share = level_share(level.lattice.sample_m(radius_m), spacing_m, float(factor))
            at = np.flatnonzero((kept > 0.0) & (share > 0.0))
            if not at.size:
                continue
            found = sample_level(level, world, at)
            if found is None:
                continue
            at = at[found.at]
            to_points = world.jacobian(level.lattice, at)
            weight = share[at] * found.weight
            d_weight = share[at] * _chain(found.d_weight, to_points)
            d_height = _chain(found.d_height, to_points)
            k, dk = kept[at], d_kept[:, at]
            d_seen[:, at] += (dk * weight + k * d_weight) * found.height + k * weight * d_height
            d_kept[:, at] = dk * (1.0 - weight) - k * d_weight
            kept[at] = k * (1.0 - weight)
            gone = kept < DONE
            kept[gone] = 0.0
            d_kept[:, gone] = 0.0
        nothing = np.zeros(count)
        return Composed(height, rest, d_seen, kept, d_kept, relief or Relief(nothing, d_kept, nothing))


class World:
    """Where points (3, N) are on maps."""

    def __init__(self, points: Floats) -> None:
        self._points = points
        self._latitude, self._longitude = sphere_place(points)
        self._known: dict[bool, tuple[Floats, Floats]] = {}

    def place(self, lattice: Lattice) -> tuple[Floats, Floats]:
        if lattice.mercator not in self._known:
            self._known[lattice.mercator] = lattice.world(self._latitude, self._longitude)
        return self._known[lattice.mercator]

    def jacobian(self, lattice: Lattice, at: Ints) -> Floats:
        """(2, 3, N): derivatives of columns and rows by the points."""
        x, y, z = self._points[:, at]
        flat2 = np.maximum(x * x + y * y, 1e-12 * (x * x + y * y + z * z))
        flat, r2 = np.sqrt(flat2), flat2 + z * z
        by_column = np.stack([-y, x, np.zeros_like(x)]) / flat2 * (lattice.across / (2.0 * np.pi))
        by_latitude = np.stack([-x * z / flat, -y * z / flat, flat]) / r2
        steep = np.sqrt(r2) / flat * 0.5 if lattice.mercator else 1.0
        return np.stack([by_column, by_latitude * (-lattice.down / np.pi) * steep])


def _chain(by_place: Floats, jacobian: Floats) -> Floats:
    return by_place[0] * jacobian[0] + by_place[1] * jacobian[1]


@dataclass(frozen=True)
class _Sampled:
    """at: which of the places asked for are in a page; derivatives (2, N) by column and row; block (3, N): which number
    of PageLevel.slopes is about there; taps (4, 4, N): samples around, rows first; towards (2, N): 0 at a pole, 1
    from a sample's distance on, and its derivative by row."""

    at: Ints
    height: Floats
    weight: Floats
    d_height: Floats
    d_weight: Floats
    block: Ints
    in_page: tuple[Ints, Floats, Floats]
    taps: Floats
    fraction: tuple[Floats, Floats]
    towards: Floats

    def falls(self, to_points: Floats, slopes: bool) -> Floats:
        """(12, M): the gradient of the B-spline through the samples and, where slopes are asked for, its derivatives
        [a, b]; to_points (2, 3, M): of columns and rows by the points, which count as straight."""
        (wx, dx), (wy, dy) = (_spline(f) for f in self.fraction)
        out = np.zeros((12, len(self.at)))
        by = np.stack([np.einsum("an,bn,ban->n", dx, wy, self.taps), np.einsum("an,bn,ban->n", wx, dy, self.taps)])
        out[:3] = _chain(by * self.towards[0], to_points)
        if slopes:
            ddx, ddy = (_bends(f) for f in self.fraction)
            xx = np.einsum("an,bn,ban->n", ddx, wy, self.taps)
            xy = np.einsum("an,bn,ban->n", dx, dy, self.taps)
            yy = np.einsum("an,bn,ban->n", wx, ddy, self.taps)
            second = np.stack([np.stack([xx, xy]), np.stack([xy, yy])]) * self.towards[0]
            out[3:] = np.einsum("ian,ijn,jbn->abn", to_points, second, to_points).reshape(9, -1)
        return out

    def roughness(self, level: PageLevel, slopes: bool) -> tuple[Floats, Floats]:
        """Metres (M,) that samples differ by, none at a pole, and derivatives (2, M) by column and row."""
        page, x, y = self.in_page
        x, y = x * (1.0 / ROUGH_SIDE) + 2.0, y * (1.0 / ROUGH_SIDE) + 2.0
        i, j = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
        taps = level.rough_taps(page, j, i)
        (wx, dx), (wy, dy) = _spline(x - i), _spline(y - j)
        value = np.einsum("an,bn,ban->n", wx, wy, taps)
        if not slopes:
            return value * self.towards[0], np.zeros((2, len(value)))
        by = np.stack([np.einsum("an,bn,ban->n", dx, wy, taps), np.einsum("an,bn,ban->n", wx, dy, taps)])
        by *= self.towards[0] * (1.0 / ROUGH_SIDE)
        by[1] += value * self.towards[1]
        return value * self.towards[0], by


def sample_level(level: PageLevel, world: World, at: Ints) -> _Sampled | None:
    u, v = (w[at] for w in world.place(level.lattice))
    page, j, i, fx, fy = level.find(u, v)
    inside = np.flatnonzero(level.there(page))
    if not inside.size:
        return None
    page, j, i, fx, fy = page[inside], j[inside], i[inside], fx[inside], fy[inside]
    heights = level.height_taps(page, j, i)
    rows = [limited_cubic(heights[b], fx) for b in range(4)]
    height, by_y, by_x = limited_cubic(np.stack([r[0] for r in rows]), fy, np.stack([r[1] for r in rows]))
    assert by_x is not None
    d_height = np.stack([by_x, by_y])
    weight, d_weight = np.ones(len(page)), np.zeros((2, len(page)))
    faded = level.weighed(page)
    if faded.size:
        taps = level.weight_taps(page[faded], j[faded], i[faded])
        (wx, dx), (wy, dy) = _spline(fx[faded]), _spline(fy[faded])
        weight[faded] = np.clip(np.einsum("an,bn,ban->n", wx, wy, taps), 0.0, 1.0)
        d_weight[0, faded] = np.einsum("an,bn,ban->n", dx, wy, taps)
        d_weight[1, faded] = np.einsum("an,bn,ban->n", wx, dy, taps)
        weight[weight > 1.0 - DONE] = 1.0
    towards = np.stack([np.ones(len(page)), np.zeros(len(page))])
    if not level.lattice.mercator:
        _towards_poles(level, v[inside], height, weight, d_height, d_weight, towards)
    block, place = np.stack([page, j // STEEP_SIDE, i // STEEP_SIDE]), (page, i + fx - BEFORE, j + fy - BEFORE)
    return _Sampled(inside, height, weight, d_height, d_weight, block, place, heights, (fx, fy), towards)


def _spline(f: Floats) -> tuple[Floats, Floats]:
    """Weights of the cubic B-spline (4, N), and their derivatives."""
    g = 1.0 - f
    weights = np.stack([g * g * g, 4.0 - f * f * (6.0 - 3.0 * f), 4.0 - g * g * (6.0 - 3.0 * g), f * f * f]) / 6.0
    slopes = np.stack([-0.5 * g * g, f * (1.5 * f - 2.0), -g * (1.5 * g - 2.0), 0.5 * f * f])
    return weights, slopes


def _bends(f: Floats) -> Floats:
    """(4, N): second derivatives of these weights."""
    return np.stack([1.0 - f, 3.0 * f - 2.0, 1.0 - 3.0 * f, f])


def _towards_poles(
    level: PageLevel, v: Floats, height: Floats, weight: Floats, d_height: Floats, d_weight: Floats, towards: Floats
) -> None:
    """Between the last row and the pole all meridians come to the same height."""
    lattice = level.lattice
    width = lattice.phase_y if lattice.phase_y > 0.0 else 1.0
    for k, (away, sign) in enumerate(((v * lattice.down, 1.0), ((1.0 - v) * lattice.down, -1.0))):
        near = np.flatnonzero(away < width)
        if not near.size:
            continue
        t = np.maximum(away[near], 0.0) / width
        f, d_f = t * t * (3.0 - 2.0 * t), 6.0 * t * (1.0 - t) / width * sign
        towards[:, near] = f, d_f
        for value, slope, there in zip((height, weight), (d_height, d_weight), level.polar[k], strict=True):
            over = value[near] - there
            value[near] = there + f * over
            slope[:, near] *= f
            slope[1, near] += d_f * over
