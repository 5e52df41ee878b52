"""Rays against the ground, float64: steps that the ground can't reach into, then a bracket and its root.

Over a stretch of length D between two places whose heights are known, ground stays within E(D) of the straight line
between them, where E is small for what is smooth over D, and grows like the relief itself beyond:

    E(D) = broad D min(1/2, pi/4 D / L) + sharp D / 2 + rough e(D) + D^2 / (8 r)

broad, rough, sharp: what the ground is like at the two ends (height_octaves.heights_steepness); L: an effective
wavelength of the ranges; e(D): of the relief layers together, four standard deviations; the last term is the planet's
curve. A step of D is free when both ends are clear of the ground by more than E(D). Compared with a bound on slopes
alone (the sphere tracing of Hart 1996), steps grow faster than the clearance, because E doesn't grow like D.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...engine.space import ray_sphere_from
from .height import TerrainField
from .height_model import RIDGE_ROUND, RIDGE_SLOPE, SHAPE_LAYERS, Model

__all__ = ["Deviation", "raycast"]

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

_SMALLEST_STEP_M = 1e-3
_ON_GROUND_M = 1e-8
"""Ten steps of a position on Earth in double precision."""
_NOISE_RMS, _NOISE_SLOPE = 0.27, 0.86
"""Of one octave of gradient noise; its slope by the lattice coordinate."""
_SIGMAS = 4.0
_RATIO = 1.5
_FEW, _TOGETHER = 250, 4
_KINDS = ("broad", "rough", "sharp")
_MARGIN = 1.2
"""Steps are chosen so that the clearance that they are expected to end with exceeds E by this."""


@dataclass(frozen=True)
class Deviation:
    """E(D) for one ground. lengths_m: (S,) geometric steps; relief: e of them; broad: the first term's factor."""

    lengths_m: Floats
    relief: Floats
    broad: Floats
    curve: Floats
    smooth_m: float
    """Over less than this even the finest layer is a parabola."""

    @classmethod
    def of(cls, model: Model) -> Deviation:
        finest = float(model.wavelength_m[-1])
        count = int(np.ceil(np.log(2.0 * model.params.radius_m / 1e-3) / np.log(_RATIO)))
        d: Floats = np.asarray(1e-3 * _RATIO ** np.arange(count), dtype=np.float64)
        by_wave = d[:, None] / model.wavelength_m
        plain = _NOISE_RMS * np.minimum(1.5, 0.25 * (_NOISE_SLOPE / _NOISE_RMS * by_wave) ** 2)
        # A crest is a kink, rounded off over RIDGE_ROUND.
        round_off = RIDGE_SLOPE / RIDGE_ROUND * (_NOISE_SLOPE * by_wave) ** 2 / 8.0
        kink = np.minimum(np.minimum(0.55, 0.5 * RIDGE_SLOPE * _NOISE_SLOPE * by_wave), round_off)
        share = np.abs(model.ridge)
        layers = model.amplitude_m * ((1.0 - share) * plain + share * kink)
        ranges = 0.25 * float(model.wavelength_m[min(SHAPE_LAYERS, len(model.wavelength_m)) - 1])
        return cls(
            d,
            _SIGMAS * np.sqrt((layers**2).sum(axis=1)),
            np.asarray(d * np.minimum(0.5, 0.25 * np.pi * d / ranges), dtype=np.float64),
            d * d / (8.0 * model.params.radius_m),
            0.25 * finest,
        )

    def table(self, broad: Floats, rough: Floats, sharp: Floats) -> Floats:
        """E (N, S) at all lengths, for N kinds of ground."""
        return (
            np.outer(broad, self.broad)
            + np.outer(sharp, 0.5 * self.lengths_m)
            + np.outer(rough, self.relief)
            + self.curve
        )

    def at(self, d: Floats, broad: Floats, rough: Floats, sharp: Floats) -> Floats:
        """E (N,) over lengths d (N,)."""
        x = np.log(np.maximum(d, self.lengths_m[0]) / self.lengths_m[0]) / np.log(_RATIO)
        k = np.minimum(x.astype(np.int64), len(self.lengths_m) - 2)
        f = x - k
        relief = self.relief[k] + f * (self.relief[k + 1] - self.relief[k])
        smooth = self.broad[k] + f * (self.broad[k + 1] - self.broad[k])
        curve = self.curve[k] + f * (self.curve[k + 1] - self.curve[k])
        return broad * smooth + 0.5 * sharp * d + rough * relief + curve


class _Rays:
    """The rays that are still going, as arrays that are cut down together."""

    def __init__(self, index: NDArray[np.intp], **columns: Floats) -> None:
        self.index = index
        self.columns = columns

    def __getattr__(self, name: str) -> Floats:
        return self.columns[name]

    def keep(self, which: Flags) -> None:
        self.index = self.index[which]
        self.columns = {name: values[which] for name, values in self.columns.items()}


def raycast(field: TerrainField, origins: Floats, directions: Floats, max_distance_m: Floats) -> tuple[Flags, Floats]:
    """First crossing of the ground along rays: hit (N,), distance_m (N,), inf where there is none.

    Rays start where they enter the shell between the bounds of the ground. Steps are at least 1 mm, 5 % more after each
    that was so short, and a millionth of the distance: a ray that grazes a crest may pass through less of it. A root
    is bracketed on a stretch where the clearance only falls, and then solved to less than a micrometre. An origin
    below the ground is a hit at distance 0.
    """
    count = len(origins)
    top = ray_sphere_from(origins, directions, field.radius_m + field.highest_m)
    bottom = ray_sphere_from(origins, directions, field.radius_m + field.lowest_m)
    outside = np.linalg.norm(origins, axis=1) > field.radius_m + field.highest_m
    near = np.where(outside, top.near_m, 0.0)
    limit = np.minimum(np.where(outside, top.far_m, top.near_m), max_distance_m)
    # From above, the lowest ground is reached by then. (From below it the origin itself is a hit.)
    limit = np.minimum(limit, np.where(bottom.hit, bottom.near_m, np.inf))
    hit, distance_m = np.zeros(count, dtype=bool), np.full(count, np.inf)
    index = np.flatnonzero((top.hit | ~outside) & (near <= limit) & (near <= max_distance_m))
    if not index.size:
        return hit, distance_m
    deviation = Deviation.of(field.model)

    def look(at: NDArray[np.intp], t: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        p = origins[at] + t[:, None] * directions[at]
        distance = np.maximum(np.linalg.norm(p, axis=1), 1e-9)
        heights, broad, rough, sharp = field.height_steepness(p / distance[:, None])
        return distance - field.radius_m - heights, broad, rough, sharp

    clearance, broad, rough, sharp = look(index, near[index])
    buried = clearance <= 0.0
    hit[index[buried]], distance_m[index[buried]] = True, near[index[buried]]
    start = origins[index] + near[index, None] * directions[index]
    rate = (start * directions[index]).sum(axis=1) / np.maximum(np.linalg.norm(start, axis=1), 1e-9)
    rays = _Rays(
        index, t=near[index], c=clearance, broad=broad, rough=rough, sharp=sharp, rate=rate,
        cap=np.full(len(index), np.inf), smallest=np.full(len(index), _SMALLEST_STEP_M), end=limit[index],
    )  # fmt: skip
    rays.keep(~buried)
    brackets: list[tuple[NDArray[np.intp], Floats, Floats]] = []
    while rays.index.size:
        least = np.maximum(rays.smallest, 1e-6 * rays.t)
        step = np.maximum(_free_step(deviation, rays), least)
        # Where the line meets the ground soon, look a little behind it: a bracket, if the ground is smooth so far.
        meets = rays.c / np.maximum(-rays.rate, 1e-12)
        near_end = (1.25 * meets < deviation.smooth_m) & (rays.cap == np.inf)
        step = np.where(near_end, np.maximum(1.25 * meets, step), np.minimum(step, np.maximum(rays.cap, least)))
        # A few rays take as long as many: then several steps are looked at together, and taken while they are free.
        several = _TOGETHER if rays.index.size <= _FEW else 1
        times = np.minimum(rays.t + step * np.arange(1, several + 1)[:, None], rays.end)
        seen = look(np.tile(rays.index, several), times.ravel())
        seen = [values.reshape(several, -1) for values in seen]
        going, crossed = np.ones(rays.index.size, dtype=bool), np.zeros(rays.index.size, dtype=bool)
        columns = rays.columns
        for t, c, *kind in zip(times, *seen, strict=True):
            going &= t > rays.t
            step = np.maximum(t - rays.t, 1e-12)
            ends = [np.maximum(now, rays.columns[name]) for now, name in zip(kind, _KINDS, strict=True)]
            e = deviation.at(step, *ends)
            small = step <= 1.0001 * np.maximum(rays.smallest, 1e-6 * rays.t)
            falls = small | ((step <= deviation.smooth_m) & (rays.c - c > 4.0 * e))
            new = going & (c <= 0.0) & falls
            if new.any():
                brackets.append((rays.index[new], rays.t[new], t[new]))
                crossed |= new
            accepted = going & (c > 0.0) & ((np.minimum(c, rays.c) >= e) | falls)
            columns["rate"] = np.where(going, (c - rays.c) / step, rays.rate)
            columns["cap"] = np.where(accepted, np.inf, np.where(going, 0.5 * step, rays.cap))
            columns["smallest"] = np.where(accepted & small, 1.05, 1.0) * rays.smallest
            for name, values in zip(("t", "c", *_KINDS), (t, c, *kind), strict=True):
                columns[name] = np.where(accepted, values, columns[name])
            going = accepted
        rays.keep(~crossed & (rays.t < rays.end))
    if brackets:
        found, above, below = (np.concatenate(part) for part in zip(*brackets, strict=True))
        hit[found] = True
        distance_m[found] = _solve(field, origins[found], directions[found], above, below)
    return hit, distance_m


def _free_step(deviation: Deviation, rays: _Rays) -> Floats:
    """The longest step (N,) at whose end the clearance, as it changes now, still exceeds E."""
    left = rays.c[:, None] + np.minimum(rays.rate, 0.0)[:, None] * deviation.lengths_m
    free = left > _MARGIN * deviation.table(rays.broad, rays.rough, rays.sharp)
    last = np.maximum(free.argmin(axis=1) - 1, 0)  # the first length that isn't free ends it
    return deviation.lengths_m[np.where(free.all(axis=1), free.shape[1] - 1, last)]


def _solve(field: TerrainField, origins: Floats, directions: Floats, above: Floats, below: Floats) -> Floats:
    """Distances where rays cross the ground between `above` it and `below` it: Illinois false position."""

    def clearance(at: NDArray[np.intp], t: Floats) -> Floats:
        p = origins[at] + t[:, None] * directions[at]
        distance = np.linalg.norm(p, axis=1)
        return distance - field.radius_m - field.height(p / distance[:, None])

    result = below.copy()
    at, a, b = np.arange(len(above)), above, below
    fa, fb = np.split(clearance(np.concatenate([at, at]), np.concatenate([a, b])), 2)
    for _ in range(60):
        if not at.size:
            break
        span = np.where(fa - fb > 0.0, fa - fb, 1.0)
        middle = np.clip(a + (b - a) * fa / span, a, b)
        f = clearance(at, middle)
        up = f > 0.0
        fb, fa = np.where(up, 0.5 * fb, f), np.where(up, f, 0.5 * fa)
        a, b = np.where(up, middle, a), np.where(up, b, middle)
        done = (b - a < 1e-7) | (np.abs(f) < _ON_GROUND_M)
        result[at] = np.where(np.abs(f) < _ON_GROUND_M, middle, b)
        at, a, b, fa, fb = (v[~done] for v in (at, a, b, fa, fb))
    return result
