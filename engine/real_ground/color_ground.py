"""Pictures of the ground, sampled: sets of levels, each half as fine as the one before, the finest set on top. Twin of
assets/shaders/terrain/real_colors.glsl.

A footprint shows what lies between the two levels whose pixels are next to it in size, linear in both and between
pixels. Where a set's weight is below 1, the next set shows by the rest, and below all of them the ground.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .block_keys import names_of, numbers_of
from .color_level import SIDE, ColorLevel, decoded, near_blocks
from .lattice import Lattice, sphere_place

__all__ = [
    "BEFORE",
    "SLOT",
    "WHOLE",
    "ColorGround",
    "ColorPages",
    "ColorSet",
    "color_page",
    "composed",
    "pages_of_colors",
    "taps_of_pixels",
]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

BEFORE, SLOT = 1, SIDE + 2
"""Pixels of a page before its own, and all of them a side: what is linear between pixels is in one page."""

WHOLE = 0.9999
"""A weight above is 1."""


@dataclass(frozen=True, eq=False)
class ColorPages:
    """Pages of one level. pixels: (P, SLOT, SLOT, 4) as color_level.coded makes them. where: (P, 2) row and column of
    pages."""

    lattice: Lattice
    pixels: NDArray[np.uint8]
    where: Ints

    @property
    def first_column(self) -> int:
        """The lowest column that there is, of lattices whose columns never meet again."""
        return 0 if self.lattice.period else int(self.where[:, 1].min()) * SIDE

    @cached_property
    def _names(self) -> Ints:
        return names_of(self.where)

    def numbers(self, row: Ints, column: Ints) -> Ints:
        """Of pages at rows and columns of pages (N,); -1: there is none."""
        return numbers_of(names_of(np.stack([row, column], axis=-1)), self._names)

    # -- what is asked of pages; levels that stream answer otherwise ---------------------------------------------------

    def there(self, page: Ints) -> NDArray[np.bool_]:
        """Which of pages (N,) there are."""
        return page >= 0

    def taps(self, page: Ints, j: Ints, i: Ints) -> NDArray[np.uint8]:
        """(2, 2, N, 4): rows, columns of pixels of slots at (j, i) and the next."""
        return taps_of_pixels(self.pixels, page, j, i)

    @property
    def nbytes(self) -> int:
        """Of all its pixels."""
        return self.pixels.nbytes

    # ------------------------------------------------------------------------------------------------------------------

    def sample(self, latitude_deg: Floats, longitude_deg: Floats) -> Floats:
        """Values times weight, and the weight, (4, N), linear between pixels."""
        counted, y = self.lattice.index(*self.lattice.world(latitude_deg, longitude_deg))
        low = self.first_column
        x = low + np.mod(counted - low, self.lattice.across)
        i, j = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
        page_y, page_x = np.maximum(j // SIDE, 0), i // SIDE
        number = self.numbers(page_y, page_x)
        out, there = np.zeros((4, len(x))), np.flatnonzero(self.there(number))
        row, column = (j - page_y * SIDE + BEFORE)[there], (i - page_x * SIDE + BEFORE)[there]
        taps = self.taps(number[there], row, column)
        for b in range(2):
            for a in range(2):
                share = np.abs(1 - b - (y - j)[there]) * np.abs(1 - a - (x - i)[there])
                out[:, there] += share * decoded(taps[b, a]).astype(np.float64).T
        return out


def taps_of_pixels(pixels: NDArray[np.uint8], page: Ints, j: Ints, i: Ints) -> NDArray[np.uint8]:
    """(2, 2, N, 4): rows, columns about pixels (j, i) of pages (N,)."""
    rows = [pixels[page, np.clip(j + b, 0, SLOT - 1), i + a] for b in range(2) for a in range(2)]
    return np.stack(rows).reshape(2, 2, len(page), 4)


@dataclass(frozen=True, eq=False)
class ColorSet:
    """Levels of one set, the finest first. octaves: by how many factors of two each is coarser than the finest.
    sun_deg: azimuth and elevation of the sun that was taken out of it, None: none was."""

    levels: tuple[ColorPages, ...]
    octaves: tuple[float, ...]
    sun_deg: tuple[float, float] | None = None

    @property
    def step_deg(self) -> float:
        return self.levels[0].lattice.step_deg

    def octave(self, latitude_deg: Floats, footprint_rad: Floats) -> Floats:
        """How many octaves coarser than the finest pixels a footprint is, the longer way across a pixel."""
        lattice = self.levels[0].lattice
        flat = np.maximum(np.cos(np.radians(latitude_deg)), 1e-6)
        east = lattice.across / (2.0 * np.pi) / flat
        south = lattice.down / (2.0 * np.pi) / flat if lattice.mercator else lattice.down / np.pi
        return np.log2(np.maximum(footprint_rad * np.maximum(east, south), 1.0))

    def sample(self, latitude_deg: Floats, longitude_deg: Floats, footprint_rad: Floats) -> Floats:
        """As ColorPages.sample, as a footprint (N,) shows it."""
        octave = np.minimum(self.octave(latitude_deg, footprint_rad), self.octaves[-1])
        out = np.zeros((4, len(latitude_deg)))
        for number, level in enumerate(self.levels):
            share = np.zeros(len(octave))
            at = self.octaves[number]
            if number:
                before = self.octaves[number - 1]
                rising = (octave > before) & (octave <= at)
                share[rising] = (octave[rising] - before) / (at - before)
            if number + 1 < len(self.levels):
                after = self.octaves[number + 1]
                falling = (octave > at) & (octave < after)
                share[falling] = (after - octave[falling]) / (after - at)
            share[octave == at] = 1.0
            near = np.flatnonzero(share > 0.0)
            if near.size:
                out[:, near] += share[near] * level.sample(latitude_deg[near], longitude_deg[near])
        return out


@dataclass(frozen=True, eq=False)
class ColorGround:
    """Sets, the finest first. Equal only to itself."""

    sets: tuple[ColorSet, ...]

    def sample(self, points: Floats, footprint_rad: Floats) -> tuple[Floats, Floats]:
        """Values (3, N) times their weight, and the weight (N,), at points (3, N) as footprints (N,) show them."""
        latitude, longitude = sphere_place(points)
        return composed(self.sets, latitude, longitude, footprint_rad)


def composed(
    sets: Sequence[ColorSet], latitude_deg: Floats, longitude_deg: Floats, footprint_rad: Floats
) -> tuple[Floats, Floats]:
    """What sets over one another show, the first on top."""
    values, rest = np.zeros((3, len(latitude_deg))), np.ones(len(latitude_deg))
    for each in sets:
        at = np.flatnonzero(rest > 0.0)
        if not at.size:
            break
        found = each.sample(latitude_deg[at], longitude_deg[at], footprint_rad[at])
        values[:, at] += rest[at] * found[:3]
        rest[at] *= np.where(found[3] > WHOLE, 0.0, 1.0 - found[3])
    return values, 1.0 - rest


def pages_of_colors(level: ColorLevel) -> ColorPages | None:
    """The pages of a level; None where it has no pixel."""
    found, where = [], []
    for j, i in near_blocks(level):
        slot = color_page(level, j, i)
        if slot is not None:
            found.append(slot)
            where.append((j, i))
    return ColorPages(level.lattice, np.stack(found), np.array(where, dtype=np.int64)) if found else None


def color_page(level: ColorLevel, j: int, i: int) -> NDArray[np.uint8] | None:
    """(SLOT, SLOT, 4): the page in row j and column i of pages; None where nothing is."""
    slot = level.window(j * SIDE - BEFORE, i * SIDE - BEFORE, SLOT, SLOT)
    return slot if slot[..., 3].any() else None
