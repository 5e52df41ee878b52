"""Which pages of real ground a view needs: those whose samples are wide enough on its screen, the widest first."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...engine.real_ground.lattice import directions_at
from ...engine.real_ground.pages import PAGE
from ...engine.real_ground.real_ground import LEVEL_SAMPLES
from ...engine.real_ground.streamed_level import StreamedLevel

__all__ = ["Eye", "PageReach", "Wanted"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_EARLY = 1.25
"""So many times as far as where a page begins to show it is wanted: it is there when it comes to show."""
_BEHIND = 0.5
"""What is out of the picture counts as if its samples were so much narrower: heads turn."""
_BESIDE_RAD = 0.15
"""Pages so far out of the picture count as in it."""


@dataclass(frozen=True)
class Eye:
    """A view's: place (3,) from the planet's centre, height above the ground, the angle of a pixel, where it looks (3,)
    and half of how far around."""

    position_m: Floats
    above_m: float
    pixel_rad: float
    forward: Floats
    half_rad: float

    @property
    def key(self) -> tuple[object, ...]:
        """Differs whenever what it wants may."""
        return self.position_m.tobytes(), self.above_m, self.pixel_rad, self.forward.tobytes(), self.half_rad


@dataclass(frozen=True, eq=False)
class Wanted:
    """Pages (N,) of a level: their numbers, and how many pixels wide their nearest samples are."""

    level: int
    pages: Ints
    sample_px: Floats


class PageReach:
    """Where the pages of a level are. number: of the level; factor: to the next one; radius_m: of the planet."""

    def __init__(self, level: StreamedLevel, number: int, factor: int, radius_m: float, highest_m: float) -> None:
        self.level, self.number, self.factor = level, number, factor
        self._radius_m, self._highest_m = radius_m, highest_m
        self.sample_m = level.lattice.sample_m(radius_m)
        self._columns = -(-level.lattice.period // PAGE)

    @cached_property
    def _half_m(self) -> float:
        """From a page's middle to its corners."""
        return 0.5 * 2.0**0.5 * PAGE * self.sample_m

    def middles(self, pages: Ints) -> Floats:
        """Unit vectors (N, 3)."""
        where = (self.level.where[pages] + 0.5) * PAGE
        return directions_at(*self.level.lattice.place(where[:, 1], where[:, 0])).T

    def distances_m(self, middles: Floats, eye: Eye) -> Floats:
        """From the eye to the nearest ground of pages (N,)."""
        up = eye.position_m / np.linalg.norm(eye.position_m)
        along = 2.0 * np.arcsin(np.clip(0.5 * np.linalg.norm(middles - up, axis=1), 0.0, 1.0)) * self._radius_m
        return np.hypot(np.maximum(along - self._half_m, 0.0), max(eye.above_m, 1.0))

    def shows(self, pages: Ints, eye: Eye, spacing_rad: float) -> NDArray[np.bool_]:
        """Which of pages (N,) show anything where what shows them is at least spacing_rad apart, seen from the eye."""
        return self._wide(self.distances_m(self.middles(pages), eye) * spacing_rad)

    def _wide(self, spacing_m: Floats) -> NDArray[np.bool_]:
        return LEVEL_SAMPLES * spacing_m < self.factor * self.sample_m

    def wanted(self, eye: Eye) -> Wanted:
        """The pages that the eye needs."""
        pages = self._around(eye)
        middles = self.middles(pages)
        distance_m = self.distances_m(middles, eye)
        px = self.sample_m / (distance_m * eye.pixel_rad)
        shown = self._wide(distance_m * eye.pixel_rad / _EARLY) & (distance_m < self._horizon_m(eye) + self._half_m)
        toward = middles * self._radius_m - eye.position_m
        length = np.maximum(np.linalg.norm(toward, axis=1), 1e-6)
        off = np.arccos(np.clip(toward @ eye.forward / length, -1.0, 1.0))
        behind = off > eye.half_rad + _BESIDE_RAD + np.arctan2(self._half_m, length)
        px = np.where(behind, _BEHIND * px, px)
        return Wanted(self.number, pages[shown], px[shown])

    def _horizon_m(self, eye: Eye) -> float:
        r = self._radius_m
        away = np.linalg.norm(eye.position_m)
        return float(r * sum(np.arccos(min(r / max(h, r), 1.0)) for h in (away, r + max(self._highest_m, 0.0))))

    def _around(self, eye: Eye) -> Ints:
        """Pages that may be near enough."""
        lattice, page_m = self.level.lattice, PAGE * self.sample_m
        reach_m = _EARLY * self.factor * self.sample_m / (LEVEL_SAMPLES * eye.pixel_rad)
        reach_m = min(reach_m, self._horizon_m(eye)) + 2.0 * self._half_m
        x, y, z = eye.position_m / np.linalg.norm(eye.position_m)
        latitude, longitude = np.degrees(np.arctan2(z, np.hypot(x, y))), np.degrees(np.arctan2(y, x))
        far = np.degrees(min(reach_m / self._radius_m, 0.5 * np.pi))
        ends = np.clip([latitude + far, latitude - far], -90.0, 90.0)
        u, v = lattice.world(ends, np.full(2, longitude))
        column, row = lattice.index(u, v)
        first, last = (int(n) for n in np.floor(row / PAGE))
        flat = max(np.cos(np.radians(np.abs(ends).max())), 1e-6)
        wide = int(np.ceil(reach_m / (page_m * flat))) + 1
        middle = int(np.floor(column[0] / PAGE))
        low, high = self.level.where.min(axis=0), self.level.where.max(axis=0)
        rows = np.arange(max(first, int(low[0])), min(last, int(high[0])) + 1)
        once = self._columns or int(np.ceil(lattice.across / PAGE))  # around the world
        wide, turns = min(wide, once // 2 + 1), (-once, 0, once)
        columns = np.unique(np.concatenate([np.arange(middle - wide, middle + wide + 1) + turn for turn in turns]))
        columns = columns[(columns >= low[1]) & (columns <= high[1])]
        if not len(rows) or not len(columns):
            return np.zeros(0, np.int64)
        at = np.meshgrid(rows, columns, indexing="ij")
        found = self.level.numbers(at[0].ravel(), at[1].ravel())
        return found[found >= 0]
