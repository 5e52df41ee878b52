"""What Monte-Carlo paths look up instead of integrating: optical lengths to space, and where light scatters on a ray.

The first table has to be right: transmittances from it are off by 1e-5, by 3e-4 at worst, on rays that touch the top of
the absorber. The second one only steers the sampling: its own probabilities are exact, whatever it holds, so that its
coarseness costs noise and no bias.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from .air_medium import AirParameters, Floats, densities
from .air_rays import ON_GROUND
from .air_transmittance import optical_lengths, transmittance_of

BINS = 48
"""Pieces of equal probability in which a distance is sampled."""


@dataclass(frozen=True)
class LengthTable:
    """Optical lengths of rays that rise to space, by linear interpolation over height and distance to the top.

    Stored over the density at the start, which leaves a slowly varying ratio (Chapman's function); the absorber, whose
    density may be 0 there, is stored as it is.
    """

    air: AirParameters
    values: Floats
    """(X * Y, 3); x = sqrt(1 - h / thickness), y from straight up to level."""
    shape: tuple[int, int]

    def rising(self, level_m2: Floats, s_m: Floats) -> Floats:
        """(N, 3) from points at h (2 R + h) = level, at s >= 0 from the perigee of their ray, to space."""
        air, (nx, ny) = self.air, self.shape
        h = np.clip(air.height(level_m2), 0.0, air.thickness_m)
        below_top = np.maximum(air.level(air.thickness_m) - level_m2, 0.0)
        far = np.sqrt(below_top)
        near = air.thickness_m - h
        there = below_top / (np.sqrt(s_m * s_m + below_top) + s_m + 1e-30)
        x = np.sqrt(near / air.thickness_m) * (nx - 1)
        y = np.clip((there - near) / np.maximum(far - near, 1e-30), 0.0, 1.0) * (ny - 1)
        i, j = np.minimum(x.astype(np.intp), nx - 2), np.minimum(y.astype(np.intp), ny - 2)
        u, v = (x - i)[:, None], (y - j)[:, None]
        at = i * ny + j
        low = self.values[at] * (1.0 - v) + self.values[at + 1] * v
        high = self.values[at + ny] * (1.0 - v) + self.values[at + ny + 1] * v
        lengths = low + u * (high - low)
        lengths[:, 0] *= np.exp(-h / air.rayleigh_scale_height_m)
        lengths[:, 1] *= np.exp(-h / air.mie_scale_height_m)
        return lengths

    def to_space(self, level_m2: Floats, s_m: Floats) -> Floats:
        """(N, 3) to space, s of either sign; for s < 0 the line must clear the ground, or begin under it."""
        deep = level_m2 < 0.0
        if deep.any():
            # Even air as far as the sphere, and on from there.
            out = np.sqrt(s_m * s_m - np.where(deep, level_m2, 0.0))
            lengths = self.to_space(np.maximum(level_m2, 0.0), np.where(deep, out, s_m))
            lengths[deep] += (out - s_m)[deep, None] * densities(self.air, np.zeros(1))
            return lengths
        lengths = self.rising(level_m2, np.abs(s_m))
        down = s_m < 0.0
        if down.any():
            perigee = np.maximum(level_m2[down] - s_m[down] ** 2, 0.0)
            lengths[down] = 2.0 * self.rising(perigee, np.zeros(len(perigee))) - lengths[down]
        return lengths

    def between(self, level_m2: Floats, start_m: Floats, end_m: Floats) -> Floats:
        """(N, 3) between two distances from the perigee, whose level is given."""
        first, last = level_m2 + start_m**2, level_m2 + end_m**2
        # Towards the ground, seen backwards: from the end up. From under it (by more than rounding) lines go through.
        falls = (level_m2 < 0.0) & (start_m < 0.0) & (first > self.air.level(-ON_GROUND * self.air.radius_m))
        lengths = self.to_space(first, np.where(falls, -start_m, start_m)) - self.to_space(
            last, np.where(falls, -end_m, end_m)
        )
        return np.maximum(np.where(falls[:, None], -lengths, lengths), 0.0)


@lru_cache(maxsize=4)
def length_table(air: AirParameters, heights: int = 512, angles: int = 1024) -> LengthTable:
    """Fills a table by quadrature; about two seconds."""
    x, y = np.meshgrid(np.linspace(0.0, 1.0, heights), np.linspace(0.0, 1.0, angles), indexing="ij")
    h = (air.thickness_m * (1.0 - x * x)).ravel()
    level = air.level(h)
    below_top = np.maximum(air.level(air.thickness_m) - level, 0.0)
    near, far = air.thickness_m - h, np.sqrt(below_top)
    there = near + (far - near) * y.ravel()
    # there = -s + sqrt(s^2 + below_top), solved for s.
    s = np.maximum(0.5 * (below_top / np.maximum(there, 1e-30) - there), 0.0)
    perigee = level - s * s
    top = np.sqrt(np.maximum(air.level(air.thickness_m) - perigee, 0.0))
    values = optical_lengths(air, perigee, s, np.maximum(top, s), nodes=8)
    values[:, 0] *= np.exp(h / air.rayleigh_scale_height_m)
    values[:, 1] *= np.exp(h / air.mie_scale_height_m)
    return LengthTable(air, values, (heights, angles))


def sampling_edges(lengths: LengthTable, level: Floats, start: Floats, end: Floats, bins: int, even: float) -> Floats:
    """(N, bins + 1) edges in 0..1 of the way from `start` to `end` of equal shares of scattered light.

    Each wavelength counts the same. The part `even` of the samples is spread evenly over the way: at dusk light comes
    from high up, where little scatters.
    """
    air = lengths.air
    fine = 512
    u = (np.arange(fine) + 0.5) / fine
    edges = np.empty((len(level), bins + 1))
    grid = np.arange(1, bins) / bins
    for first in range(0, len(level), 128):
        part = slice(first, first + 128)
        lv, a, b = level[part, None], start[part, None], end[part, None]
        s = a + (b - a) * u
        flat = [np.broadcast_to(v, s.shape).ravel() for v in (lv, a, s)]
        through = transmittance_of(air, lengths.between(flat[0], flat[1], flat[2])).reshape(*s.shape, air.wavelengths)
        light = through * (densities(air, air.height(lv + s * s))[..., :2] @ air.scattering_per_m)
        share = (light / np.maximum(light.sum(axis=1, keepdims=True), 1e-300)).mean(axis=2)
        share = (1.0 - even) * share + even / fine
        cdf = np.concatenate([np.zeros((len(share), 1)), np.cumsum(share, axis=1)], axis=1)
        cdf /= cdf[:, -1:]
        steps = np.arange(fine + 1) / fine
        for k, row in enumerate(cdf):
            edges[first + k, 1:-1] = np.interp(grid, row, steps)
    edges[:, 0], edges[:, -1] = 0.0, 1.0
    return edges


@dataclass(frozen=True)
class DistanceTable:
    """Edges of equal probability for rays from anywhere in the shell, taken from the nearest of many cells."""

    air: AirParameters
    edges: Floats
    """(2 * heights * angles, BINS + 1): first the rays to space, then those to the ground."""
    heights: int
    angles: int

    def cells(self, level_m2: Floats, s_m: Floats, hits: NDArray[np.bool_]) -> NDArray[np.intp]:
        """(N,) rows of `edges` for rays from points at `level`, at the signed distance s from their perigee."""
        air = self.air
        h = np.clip(air.height(level_m2), 0.0, air.thickness_m)
        level = np.maximum(level_m2, 0.0)
        below_top = np.maximum(air.level(air.thickness_m) - level, 0.0)
        perigee = level - s_m * s_m
        top = np.sqrt(np.maximum(air.level(air.thickness_m) - perigee, 0.0)) - s_m
        ground = -s_m - np.sqrt(np.maximum(-perigee, 0.0))
        near = np.where(hits, h, air.thickness_m - h)
        far = np.where(hits, np.sqrt(level), np.sqrt(level) + np.sqrt(below_top))
        y = (np.where(hits, ground, top) - near) / np.maximum(far - near, 1e-30)
        i = np.clip((np.sqrt(h / air.thickness_m) * self.heights).astype(np.intp), 0, self.heights - 1)
        j = np.clip((y * self.angles).astype(np.intp), 0, self.angles - 1)
        return (hits * self.heights + i) * self.angles + j


@lru_cache(maxsize=4)
def distance_table(air: AirParameters, even: float, heights: int = 80, angles: int = 48) -> DistanceTable:
    """Fills the cells; about two seconds."""
    i, j = np.meshgrid(np.arange(heights), np.arange(angles), indexing="ij")
    h = (air.thickness_m * ((i + 0.5) / heights) ** 2).ravel()
    y = ((j + 0.5) / angles).ravel()
    level = air.level(h)
    below_top = air.level(air.thickness_m) - level
    # To space: there = -s + sqrt(s^2 + below_top); to the ground: there = -s - sqrt(s^2 - level).
    there = air.thickness_m - h + (np.sqrt(level) + np.sqrt(below_top) - air.thickness_m + h) * y
    s_space = np.maximum(0.5 * (below_top / there - there), -np.sqrt(level))
    there = h + (np.sqrt(level) - h) * y
    s_ground = np.minimum(-0.5 * (level / there + there), -np.sqrt(level))
    start = np.concatenate([s_space, s_ground])
    perigee = np.concatenate([level, level]) - start * start
    half = np.sqrt(np.maximum(air.level(air.thickness_m) - perigee, 0.0))
    hits = np.arange(len(start)) >= len(h)
    end = np.where(hits, -np.sqrt(np.maximum(-perigee, 0.0)), half)
    # Rounding aside, a ray to space has its perigee above the ground or behind it.
    perigee = np.where(~hits & (start < 0.0), np.maximum(perigee, 0.0), perigee)
    edges = sampling_edges(length_table(air), perigee, start, end, BINS, even)
    return DistanceTable(air, edges, heights, angles)
