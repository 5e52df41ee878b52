"""Impact craters, float64: the twin of assets/shaders/terrain/craters.glsl.

Each octave is a 3D lattice of cells W wide with one crater a cell at a hashed place; where the sphere passes within
W / 2 of that place there is a crater, the smaller the further off it lies. So a point need ask eight cells only, there
are no poles and no seams, and sizes are continuous. An octave's largest crater is W / 2 wide, and within it sizes
follow N(> D) ~ D^-2, as they do over octaves whose widths halve: the steady state in which new craters wipe out old
ones (Trask 1966, "Size and spatial distribution of craters estimated from the Ranger photographs", JPL Technical
Report 32-800: N(> D) = 10^10.9 D^-2 per 10^6 km^2, D in metres, 8.6 % of the area an octave). Density 1 covers 5.9 % of
the area in each octave, 0.7 of that state.

Shapes: Pike 1977, "Size-dependence in the shape of fresh impact craters on the moon" (Impact and Explosion
Cratering, 489-509): simple craters are 0.196 D^1.010 deep with rims of 0.036 D^1.014, complex ones 1.044 D^0.301 and
0.236 D^0.399, in km; the laws meet at 10.6 and 21.3 km there, elsewhere in inverse proportion to gravity, which is in
proportion to the radius at equal density. Beyond the rim ejecta fall off much as r^-3 (McGetchin, Settle and Head
1973), to 0 at two radii. Most craters are worn: a hashed share of the fresh relief, its crest rounder.

Within an octave the younger of two craters wipes out what of the older it covers; the order of age is that of the
parities of the cells, which is the same wherever one asks from. Smaller craters add to larger ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ...engine.compiled import Kernels
from ...engine.surface.noise import octave_offset
from .crater_form import CraterShape, crater_above, crater_relief, crater_slopes
from .height_steps import layer_weight

__all__ = ["MOST_OCTAVES", "Craters", "craters_of", "fresh_shape"]

Floats = NDArray[np.float64]

_COMPILED = Kernels(__package__, "crater_kernels")

MOST_OCTAVES = 18
"""Slots in the GPU's table: from 250 km down to 1 m."""

COARSE_CELL_M = 16384.0
"""Cells wider than this are evaluated as changes on the GPU: a place in them rounded to float is millimetres off."""

AREA_SHARE = np.pi / 4.0 * (np.log(4.0) / 3.0) * (1.0 / 6.0 - 1.0 / 256.0)
"""Of the ground that an octave of density 1 covers: pi R^2 a cell, 4 R^2 = (1/4 - z^2) g^2. The mean of g^2 is
ln(4) / 3, that of 1/4 - z^2 over |z| < 1/2 is 1/6, less 1/256 for what lies close to |z| = 1/2 and is left out."""

_FIRST_OFFSET = 64  # octave numbers of the seed's offsets, behind all noise
_SMALLEST_M = 0.25
_MOON_DEPTH_CHANGE_KM, _MOON_RIM_CHANGE_KM, _MOON_RADIUS_M = 10.6, 21.3, 1.7374e6


def fresh_shape(diameter_m: float, radius_m: float) -> tuple[float, float, float, float]:
    """The fields of CraterShape."""
    km = diameter_m * 1e-3 * radius_m / _MOON_RADIUS_M  # of a crater like it on the moon
    complexity, flat = max(km / _MOON_DEPTH_CHANGE_KM, 1.0), max(km / _MOON_RIM_CHANGE_KM, 1.0)
    depth, rim = 0.392 * complexity**-0.699, 0.072 * flat**-0.601
    peak = 0.25 * depth * min(complexity - 1.0, 1.0)
    wall = float(np.sqrt(0.392 * depth))
    return wall, 0.96 * depth, rim, peak


@dataclass(frozen=True, slots=True)
class Craters:
    """Octaves of craters on a sphere. `frequency` (K,) cells per metre, widest first; `offset` (K, 3) in cells; `shape`
    (K, 4) as of fresh_shape; `accept`: cells whose 8-bit draw is below it have a crater."""

    radius_m: float
    frequency: Floats
    offset: Floats
    shape: Floats
    accept: int

    def __len__(self) -> int:
        return len(self.frequency)

    @property
    def coarse(self) -> int:
        """How many octaves the GPU evaluates as changes from an anchor."""
        return int(np.count_nonzero(self.frequency < 1.0 / COARSE_CELL_M))

    @property
    def slope(self) -> float:
        """A slope that hardly any crater ground exceeds: a fresh wall, and three standard deviations of the rest."""
        wall = 2.0 * self.shape[:, 0]
        spread = wall**2 * (0.25 * AREA_SHARE * self.accept / 256.0)
        return float(wall.max() + 3.0 * np.sqrt(spread.sum()))

    def heights(self, points: Floats) -> Floats:
        """Heights (N,) that craters add at `points` (3, N), metres."""
        if (compiled := _COMPILED()) is not None:
            return compiled.heights(self, points)
        return self._evaluate(points, None, gradients=False)[0]

    def octave_heights(self, points: Floats) -> Floats:
        """Heights (K, N) that each octave adds at `points` (3, N), metres."""
        if (compiled := _COMPILED()) is not None:
            return compiled.octave_heights(self, points)
        return self._octaves(slice(None), points, None, gradients=False)[0]

    def heights_gradients(self, points: Floats, footprint_m: Floats | None) -> tuple[Floats, Floats]:
        """Heights (N,) and 3D gradients (3, N), these limited to what `footprint_m` (N,) shows of them."""
        return self._evaluate(points, footprint_m, gradients=True)

    def _evaluate(self, points: Floats, footprint_m: Floats | None, gradients: bool) -> tuple[Floats, Floats]:
        count = points.shape[1]
        height, gradient = np.zeros(count), np.zeros((3, count if gradients else 0))
        together = max(_TOGETHER // max(count, 1), 1)
        for start in range(0, len(self), together):
            part = slice(start, start + together)
            h, g = self._octaves(part, points, footprint_m, gradients)
            for k in range(len(h)):  # one by one, so that heights don't depend on the batch
                height += h[k]
                if gradients:
                    gradient += g[:, k]
        return height, gradient

    def _octaves(
        self, part: slice, points: Floats, footprint_m: Floats | None, gradients: bool
    ) -> tuple[Floats, Floats]:
        """Heights (octaves, N) and gradients (3, octaves, N)."""
        frequency = self.frequency[part]
        octaves, count = len(frequency), points.shape[1]
        place = points[:, None] * frequency[:, None] + self.offset[part].T[:, :, None] - 0.5  # (3, K, N)
        base = np.floor(place)
        place -= base
        low = base.astype(np.int64).astype(np.uint32)
        first = low[0] * STEPS[0] + low[1] * STEPS[1] + low[2] * STEPS[2]
        odd = (low & 1).astype(bool)
        word = np.empty((8, octaves, count), dtype=np.uint32)
        sides = np.empty((3, 2, octaves, count), dtype=np.uint32)  # by parity: on which side of the base
        for axis in range(3):
            sides[axis, 0], sides[axis, 1] = odd[axis], ~odd[axis]
        steps = sides * STEPS[:, None, None, None]
        for c in range(8):  # by age: oldest first
            np.add(first, steps[0, c & 1], out=word[c])
            word[c] += steps[1, c >> 1 & 1]
            word[c] += steps[2, c >> 2]
        word = mixed(word)
        near = [place[axis] + 0.5 - sides[axis] for axis in range(3)]  # (2, K, N)
        vv = np.zeros((8, octaves, count))
        for axis in range(3):
            across = np.stack([near[axis][c >> axis & 1] for c in range(8)])
            across -= ((word >> SHIFTS[axis] & TEN_BITS) + 0.5) * (1.0 / 1024.0)
            vv += across * across
        parity, k, n = np.nonzero(vv < 0.25)
        hashed = word[parity, k, n]
        draw, wide, worn = draws(hashed)
        there = draw < self.accept
        parity, k, n = (a[there] for a in (parity, k, n))
        hashed, wide, worn = hashed[there], wide[there], worn[there]
        v = np.stack(
            [
                near[axis][parity >> axis & 1, k, n] - ((hashed >> SHIFTS[axis] & TEN_BITS) + 0.5) * (1.0 / 1024.0)
                for axis in range(3)
            ]
        )
        vv = v[0] * v[0] + v[1] * v[1] + v[2] * v[2]

        here = points[:, n]
        along = (v[0] * here[0] + v[1] * here[1] + v[2] * here[2]) / self.radius_m
        shape, curve = CraterShape(*self.shape[part][k].T), 1.0 / (self.radius_m * frequency[k])
        z, root = crater_above(vv, along, curve)
        place = shape, vv - z * z, z, root, 1.0, wide, worn
        total, bent = np.zeros((octaves, count)), np.zeros((3, octaves, count) if gradients else 0)
        if gradients:
            form, fresh, size, wiped, square_by_vv, slope, wiped_slope = crater_slopes(*place)
            seen = np.ones(len(n)) if footprint_m is None else layer_weight(2.0 * size / frequency[k], footprint_m[n])
            ahead = 2.0 * square_by_vv * seen * v  # of (r / R)^2, by cells
        else:
            form, fresh, size, wiped = crater_relief(*place)
            seen = ahead = slope = wiped_slope = np.zeros(0)
        height_m = form * fresh / frequency[k] * size
        edges = np.searchsorted(parity, np.arange(9))
        for a, b in pairwise(edges):
            at = k[a:b], n[a:b]
            if gradients:
                steep = size[a:b] * fresh[a:b] * slope[a:b] - total[at] * frequency[at[0]] * wiped_slope[a:b]
                bent[:, *at] = bent[:, *at] * (1.0 - seen[a:b] * wiped[a:b]) + steep * ahead[:, a:b]
            total[at] = total[at] * (1.0 - wiped[a:b]) + height_m[a:b]
        return total, bent


_TOGETHER = 20000  # octaves x points: fewer calls of numpy, for 2 MB of temporaries
STEPS = np.array([0x9E3779B1, 0x85EBCA77, 0xC2B2AE3D], dtype=np.uint32)
SHIFTS = np.array([0, 10, 22, 24], dtype=np.uint32)
TEN_BITS, OTHER = np.uint32(1023), np.uint32(0x68BC21EB)


def mixed(x: NDArray[np.uint32]) -> NDArray[np.uint32]:
    """lowbias32 (Wellons 2018, "Prospecting for hash functions"), which is half the work of PCG3D."""
    x = (x ^ (x >> np.uint32(16))) * np.uint32(0x7FEB352D)
    x = (x ^ (x >> np.uint32(15))) * np.uint32(0x846CA68B)
    return x ^ (x >> np.uint32(16))


def draws(word: NDArray[np.uint32]) -> tuple[NDArray[np.uint32], Floats, Floats]:
    """Of hashed cells: the 8-bit draw that `accept` is for, and two numbers in [0, 1) for width and wear."""
    word = mixed(word ^ OTHER)
    wide = np.asarray((word & 4095) * (1.0 / 4096.0), dtype=np.float64)
    return word >> SHIFTS[3], wide, np.asarray((word >> 12 & 4095) * (1.0 / 4096.0), dtype=np.float64)


def craters_of(density: float, largest_m: float, smallest_m: float, radius_m: float, seed: int) -> Craters | None:
    """Octaves of craters from diameters of `largest_m`, at most the planet's radius, to `smallest_m`; None for none."""
    accept = round(256 * density)
    if accept <= 0:
        return None
    widest = 2.0 ** round(np.log2(2.0 * min(largest_m, radius_m)))
    octaves = int(np.clip(np.floor(np.log2(0.5 * widest / max(smallest_m, _SMALLEST_M))) + 1, 1, MOST_OCTAVES))
    width = widest * 0.5 ** np.arange(octaves)
    return Craters(
        radius_m,
        1.0 / width,
        np.array([octave_offset(seed, _FIRST_OFFSET + k) for k in range(octaves)]),
        np.array([fresh_shape(0.35 * w, radius_m) for w in width]).astype(np.float32).astype(np.float64),
        accept,
    )
