"""Which pages of real ground a view needs: those whose samples are wide enough on its screen, the widest first."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ...engine.real_ground.lattice import Lattice, directions_at
from ...engine.real_ground.real_ground import LEVEL_SAMPLES

__all__ = ["ColorReach", "Eye", "PageReach", "ReachedLevel", "Wanted"]

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


class ReachedLevel(Protocol):
    """What is asked of a level. where: (P, 2) row and column of pages."""

    @property
    def lattice(self) -> Lattice: ...

    @property
    def where(self) -> Ints: ...

    def numbers(self, row: Ints, column: Ints) -> Ints: ...


class PageReach:
    """Where the pages of a level are. number: of the level; side: samples of a page's side; factor: to the next level;
    radius_m: of the planet."""

    samples = LEVEL_SAMPLES
    """A level shows where what shows it is less than `factor` of its samples apart, times this."""

    def __init__(
        self, level: ReachedLevel, number: int, side: int, factor: float, radius_m: float, highest_m: float
    ) -> None:  # fmt: skip
        self.level, self.number, self.side, self.factor = level, number, side, factor
        self._radius_m, self._highest_m = radius_m, highest_m
        self.sample_m = level.lattice.sample_m(radius_m)
        self._columns = -(-level.lattice.period // side)

    def widths_m(self, pages: Ints) -> Floats:
        """Of samples of pages (N,)."""
        return np.full(len(pages), self.sample_m)

    def halves_m(self, pages: Ints) -> Floats:
        """From the middles of pages (N,) to their corners."""
        return np.full(len(pages), 0.5 * 2.0**0.5 * self.side * self.sample_m)

    def middles(self, pages: Ints) -> Floats:
        """Unit vectors (N, 3)."""
        where = (self.level.where[pages] + 0.5) * self.side
        return directions_at(*self.level.lattice.place(where[:, 1], where[:, 0])).T

    def distances_m(self, middles: Floats, halves_m: Floats, eye: Eye) -> Floats:
        """From the eye to the nearest ground of pages whose middles are unit vectors (N, 3)."""
        up = eye.position_m / np.linalg.norm(eye.position_m)
        along = 2.0 * np.arcsin(np.clip(0.5 * np.linalg.norm(middles - up, axis=1), 0.0, 1.0)) * self._radius_m
        return np.hypot(np.maximum(along - halves_m, 0.0), max(eye.above_m, 1.0))

    def shows(self, pages: Ints, eye: Eye, spacing_rad: float) -> NDArray[np.bool_]:
        """Which of pages (N,) show anything where what shows them is at least spacing_rad apart, seen from the eye."""
        distances_m = self.distances_m(self.middles(pages), self.halves_m(pages), eye)
        return self._wide(distances_m * spacing_rad, self.widths_m(pages))

    def _wide(self, spacing_m: Floats, width_m: Floats) -> NDArray[np.bool_]:
        return self.samples * spacing_m < self.factor * width_m

    def wanted(self, eye: Eye) -> Wanted:
        """The pages that the eye needs."""
        pages = self._around(eye)
        middles, halves_m, width_m = self.middles(pages), self.halves_m(pages), self.widths_m(pages)
        distance_m = self.distances_m(middles, halves_m, eye)
        px = width_m / (distance_m * eye.pixel_rad)
        near_m = self.distances_m(middles, halves_m + self._beside_m(width_m), eye)
        shown = self._reached(distance_m, near_m, eye, width_m) & (distance_m < self._horizon_m(eye) + halves_m)
        toward = middles * self._radius_m - eye.position_m
        length = np.maximum(np.linalg.norm(toward, axis=1), 1e-6)
        off = np.arccos(np.clip(toward @ eye.forward / length, -1.0, 1.0))
        behind = off > eye.half_rad + _BESIDE_RAD + np.arctan2(halves_m, length)
        px = np.where(behind, _BEHIND * px, px)
        return Wanted(self.number, pages[shown], px[shown])

    def _reached(self, distance_m: Floats, near_m: Floats, eye: Eye, width_m: Floats) -> NDArray[np.bool_]:
        """Which pages are wanted: those that will show soon, and in small pictures, where less than a page shows, all
        beside what does, towards which it would fade. near_m: to what is beside them."""
        soon = self._wide(distance_m * eye.pixel_rad / _EARLY, width_m)
        return soon | self._wide(near_m * eye.pixel_rad, width_m)

    def _beside_m(self, width_m: Floats) -> Floats:
        """Pages so much farther away are wanted as well: from a place to what is beside its page across a corner."""
        return np.full(len(width_m), 2.0**0.5 * self.side * self.sample_m)

    def _horizon_m(self, eye: Eye) -> float:
        r = self._radius_m
        away = np.linalg.norm(eye.position_m)
        return float(r * sum(np.arccos(min(r / max(h, r), 1.0)) for h in (away, r + max(self._highest_m, 0.0))))

    def _around(self, eye: Eye) -> Ints:
        """Pages that may be near enough."""
        lattice, page_m = self.level.lattice, self.side * self.sample_m
        reach_m = _EARLY * self.factor * self.sample_m / (self.samples * eye.pixel_rad)
        reach_m = (
            min(reach_m, self._horizon_m(eye)) + 2.0**0.5 * page_m + float(self._beside_m(np.full(1, self.sample_m))[0])
        )
        x, y, z = eye.position_m / np.linalg.norm(eye.position_m)
        latitude, longitude = np.degrees(np.arctan2(z, np.hypot(x, y))), np.degrees(np.arctan2(y, x))
        far = np.degrees(min(reach_m / self._radius_m, 0.5 * np.pi))
        ends = np.clip([latitude + far, latitude - far], -90.0, 90.0)
        u, v = lattice.world(ends, np.full(2, longitude))
        column, row = lattice.index(u, v)
        first, last = (int(n) for n in np.floor(row / self.side))
        flat = max(np.cos(np.radians(np.abs(ends).max())), 1e-6)
        wide = int(np.ceil(reach_m / (page_m * flat))) + 1
        middle = int(np.floor(column[0] / self.side))
        low, high = self.level.where.min(axis=0), self.level.where.max(axis=0)
        rows = np.arange(max(first, int(low[0])), min(last, int(high[0])) + 1)
        once = self._columns or int(np.ceil(lattice.across / self.side))  # around the world
        wide, turns = min(wide, once // 2 + 1), (-once, 0, once)
        columns = np.unique(np.concatenate([np.arange(middle - wide, middle + wide + 1) + turn for turn in turns]))
        columns = columns[(columns >= low[1]) & (columns <= high[1])]
        if not len(rows) or not len(columns):
            return np.zeros(0, np.int64)
        at = np.meshgrid(rows, columns, indexing="ij")
        found = self.level.numbers(at[0].ravel(), at[1].ravel())
        return found[found >= 0]


class ColorReach(PageReach):
    """Of pages of pictures: a level shows where the footprint is less than the next one's pixels, whose shorter side
    counts; towards pages that are missing it fades, so those beside pages that show are wanted, too."""

    samples = 1.0

    def _reached(self, distance_m: Floats, near_m: Floats, eye: Eye, width_m: Floats) -> NDArray[np.bool_]:
        return self._wide(near_m * eye.pixel_rad / _EARLY, width_m)

    def widths_m(self, pages: Ints) -> Floats:
        rows = self.level.where[pages, 0] * self.side
        ends = [self.level.lattice.place(0.0, rows + more)[0] for more in (0, self.side)]
        north, south = ends[0], ends[1]
        nearest = np.where(north * south <= 0.0, 0.0, np.minimum(np.abs(north), np.abs(south)))  # to the equator
        return self.sample_m * np.maximum(np.cos(np.radians(np.minimum(nearest, 90.0))), 1e-6)

    def halves_m(self, pages: Ints) -> Floats:
        if not self.level.lattice.mercator:
            return super().halves_m(pages)
        return 0.5 * 2.0**0.5 * self.side * self.widths_m(pages)

    def _beside_m(self, width_m: Floats) -> Floats:
        return self.side * (width_m if self.level.lattice.mercator else np.full(len(width_m), self.sample_m))
