"""Levels of a raster as pages: squares of samples that overlap, with heights beyond the border and a weight there.

A page has PAGE samples a side that are its own, BEFORE more to the west and the north and the rest of SLOT to the east
and the south, so that all samples a cubic needs are in one page.

Beyond the samples of a level (and in its holes) heights go on for RINGS samples: those of the next coarser level, with
what the nearest samples differ from it. Their weight is 1 next to the samples and 0 at the last ring, so a level passes
into the next coarser one over a margin as wide as suits its own detail, and the coarsest into the ground around it
(multiband blending, Burt and Adelson 1983). A border is then no steeper than the ground itself is at that scale.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .lattice import Lattice
from .raw_level import BLOCK, RawLevel

__all__ = [
    "BEFORE",
    "PAGE",
    "RINGS",
    "SLOT",
    "STEEP_BLOCKS",
    "TABLE",
    "MadePage",
    "PageLevel",
    "made_page",
    "page_slopes",
    "pages_of",
    "polar_of",
    "reached",
    "taps_of",
]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Heights = NDArray[np.float32]
Coarser = Callable[[Floats, Floats], Floats]
"""Heights (N,) at latitudes and longitudes (N,), NaN where there are none."""

PAGE, BEFORE, SLOT = BLOCK, 3, 128
RINGS = 8
_WHOLE_RINGS = 1
"""Rings of full weight: smoothing weights then leaves those of samples at 1."""
STEEP_SIDE = 8
"""Samples a side of the squares that bounds on slopes are kept of."""
STEEP_BLOCKS = SLOT // STEEP_SIDE
ROUGH_SIDE, ROUGH = 20, PAGE // 20 + 5
TABLE = 32
"""Pages a side of a block of the table of pages."""


@dataclass(frozen=True, eq=False)
class PageLevel:
    """Pages of one level.

    heights: (P, SLOT, SLOT). weights: (W, SLOT, SLOT), of the pages where any is below 1, and of_weights (P,) which
    one, -1: all are 1. where: (P, 2) row and column of pages. first_column: the lowest column that there is, of
    lattices whose columns never meet again. polar: (2, 2) height and weight at the north and the south pole.
    """

    lattice: Lattice
    heights: Heights
    weights: Heights
    of_weights: Ints
    where: Ints
    polar: Floats
    roughness: Heights
    """(P, ROUGH, ROUGH): rms of the relief 2 to 4 samples wide, metres, at nodes ROUGH_SIDE samples apart; the first
    is 2 of them before the page's own."""
    finest: bool
    """Whether it holds the samples of files as they are."""

    # -- what is asked of pages; levels that stream answer otherwise ---------------------------------------------------

    def there(self, page: Ints) -> NDArray[np.bool_]:
        """Which of pages (N,) there are."""
        return page >= 0

    def height_taps(self, page: Ints, j: Ints, i: Ints) -> Floats:
        """(4, 4, N): rows, columns of samples of slots around the one at (j, i) and the next."""
        return taps_of(self.heights, page, j, i)

    def weighed(self, page: Ints) -> Ints:
        """Which of pages (N,) have weights below 1."""
        return np.flatnonzero(self.of_weights[page] >= 0)

    def weight_taps(self, page: Ints, j: Ints, i: Ints) -> Floats:
        """As height_taps, of pages that have weights."""
        return taps_of(self.weights, self.of_weights[page], j, i)

    def rough_taps(self, page: Ints, j: Ints, i: Ints) -> Floats:
        """As height_taps, of the nodes of roughness."""
        return taps_of(self.roughness, page, j, i)

    def steep_at(self, block: Ints, radius_m: float) -> Floats:
        """Largest slopes (N,) about squares of samples: block (3, N) as indices of `slopes`."""
        return self.slopes(radius_m)[tuple(block)]

    def steepest(self, radius_m: float) -> float:
        """The largest of all."""
        return float(self.slopes(radius_m).max())

    @property
    def nbytes(self) -> int:
        """Of all its heights and weights."""
        return self.heights.nbytes + self.weights.nbytes

    # ------------------------------------------------------------------------------------------------------------------

    @property
    def first_column(self) -> int:
        return 0 if self.lattice.period else int(self.where[:, 1].min()) * PAGE

    @cached_property
    def table(self) -> tuple[int, int, Ints, Ints]:
        """First row and column of blocks of TABLE x TABLE pages, blocks (rows, columns) of numbers, -1: none, and the
        pages of each block (blocks, TABLE, TABLE), -1: none."""
        block = self.where // TABLE
        first, last = block.min(axis=0), block.max(axis=0)
        blocks = np.full(last - first + 1, -1, np.int64)
        names, of = np.unique(block, axis=0, return_inverse=True)
        blocks[tuple((names - first).T)] = np.arange(len(names))
        pages = np.full((len(names), TABLE, TABLE), -1, np.int64)
        inside = self.where - block * TABLE
        pages[of.ravel(), inside[:, 0], inside[:, 1]] = np.arange(len(self.where))
        return int(first[0]), int(first[1]), blocks, pages

    def table_place(self, number: int) -> int:
        """Where a page's number is among the pages of `table`, block by block."""
        first_row, first_column, blocks, _ = self.table
        row, column = (int(v) for v in self.where[number])
        block = int(blocks[row // TABLE - first_row, column // TABLE - first_column])
        return (block * TABLE + row % TABLE) * TABLE + column % TABLE

    def slopes(self, radius_m: float) -> Floats:
        """Largest slopes (P, SLOT / STEEP_SIDE, SLOT / STEEP_SIDE) of squares of samples, one around each included."""
        known = self._slopes.get(radius_m)
        if known is None:
            known = self._slopes[radius_m] = page_slopes(self.lattice, self.heights, self.where, radius_m)
        return known

    @cached_property
    def _slopes(self) -> dict[float, Floats]:
        return {}

    def numbers(self, row: Ints, column: Ints) -> Ints:
        """Of pages at rows and columns of pages (N,), which are within the world; -1: there is none."""
        first_row, first_column, blocks, pages = self.table
        block_y, block_x = row // TABLE - first_row, column // TABLE - first_column
        inside = (block_y >= 0) & (block_x >= 0) & (block_y < blocks.shape[0]) & (block_x < blocks.shape[1])
        block = np.where(inside, blocks[np.where(inside, block_y, 0), np.where(inside, block_x, 0)], -1)
        found: Ints = np.where(block >= 0, pages[block, row % TABLE, column % TABLE], -1)
        return found

    def find(self, u: Floats, v: Floats) -> tuple[Ints, Ints, Ints, Floats, Floats]:
        """Of places of the world (N,): the page (-1: none), the sample in its slot (row, column) that is north-west of
        it, and fractions east and south of that."""
        counted, y = self.lattice.index(u, v)
        low = self.first_column
        x: Floats = low + np.mod(counted - low, self.lattice.across)
        page_x: Ints = np.floor(x / PAGE).astype(np.int64)
        page_y: Ints = np.maximum(np.floor(y / PAGE).astype(np.int64), 0)
        i: Ints = np.floor(x).astype(np.int64)
        j: Ints = np.floor(y).astype(np.int64)
        page = self.numbers(page_y, page_x)
        return page, j - page_y * PAGE + BEFORE, i - page_x * PAGE + BEFORE, x - i, y - j


def taps_of(pages: NDArray[np.float32], page: Ints, j: Ints, i: Ints) -> Floats:
    """(4, 4, N): rows, columns about samples (j, i) of pages (N,)."""
    flat, side = pages.reshape(-1), pages.shape[2]
    corner = (page * side + j - 1) * side + i - 1
    return np.stack([[flat[corner + b * side + a] for a in range(4)] for b in range(4)]).astype(np.float64)


def page_slopes(lattice: Lattice, heights: Heights, where: Ints, radius_m: float) -> Floats:
    """Of pages (P, SLOT, SLOT) at rows and columns (P, 2): see PageLevel.slopes."""
    blocks = STEEP_BLOCKS
    found = np.empty((len(heights), blocks, blocks))
    up_m = np.radians(lattice.step_deg) * radius_m
    for number, (values, (j, _)) in enumerate(zip(heights, where, strict=True)):
        rows = np.arange(SLOT) + (int(j) * PAGE - BEFORE)
        flat = np.maximum(np.cos(np.radians(lattice.place(np.zeros(SLOT), rows)[0])), 1e-3)
        down_m = up_m * (flat if lattice.mercator else np.ones(SLOT))
        east_m = 2.0 * np.pi / lattice.across * radius_m * flat
        along = np.abs(np.diff(values.astype(np.float64), axis=1, append=values[:, -1:])) / east_m[:, None]
        across = np.abs(np.diff(values.astype(np.float64), axis=0, append=values[-1:])) / down_m[:, None]
        steep = np.hypot(along, across).reshape(blocks, STEEP_SIDE, blocks, STEEP_SIDE).max(axis=(1, 3))
        wide = np.pad(steep, 1, mode="edge")
        found[number] = np.max([wide[b : b + blocks, a : a + blocks] for b in range(3) for a in range(3)], axis=0)
    return found


def pages_of(raw: RawLevel, coarser: Coarser | None, finest: bool) -> PageLevel | None:
    """The pages of a level; None where it has no height. coarser: heights of the next coarser level."""
    keys = sorted(reached(raw))
    heights, weights, of_weights, where, roughness = [], [], [], [], []
    for j, i in keys:
        found = made_page(raw, coarser, j, i)
        if found is None:
            continue
        where.append((j, i))
        roughness.append(found.roughness)
        heights.append(found.heights)
        of_weights.append(-1 if found.weights is None else len(weights))
        if found.weights is not None:
            weights.append(found.weights)
    if not where:
        return None
    return PageLevel(
        raw.lattice,
        np.stack(heights),
        np.stack(weights) if weights else np.zeros((0, SLOT, SLOT), np.float32),
        np.array(of_weights, dtype=np.int64),
        np.array(where, dtype=np.int64),
        polar_of(raw),
        np.stack(roughness),
        finest,
    )


@dataclass(frozen=True, eq=False)
class MadePage:
    """heights and weights (SLOT, SLOT), None: all are 1; roughness (ROUGH, ROUGH)."""

    heights: Heights
    weights: Heights | None
    roughness: Heights

    def arrays(self) -> dict[str, NDArray[Any]]:
        """To be written, by letters; `of` makes it of them again."""
        found = {"h": self.heights, "r": self.roughness}
        return found if self.weights is None else found | {"w": self.weights}

    @staticmethod
    def of(held: Callable[[str], NDArray[Any] | None]) -> MadePage:
        heights, roughness = held("h"), held("r")
        if heights is None or roughness is None:
            raise ValueError("half a page")
        return MadePage(heights, held("w"), roughness)


def made_page(raw: RawLevel, coarser: Coarser | None, j: int, i: int) -> MadePage | None:
    """The page in row j and column i of pages; None where nothing is."""
    found = _page(raw, coarser, j, i)
    return None if found is None else MadePage(*found, _roughness(raw, j, i))


def reached(raw: RawLevel) -> set[tuple[int, int]]:
    """Blocks with heights, and those around them."""
    lattice = raw.lattice
    columns = -(-lattice.period // BLOCK) if lattice.period else 0
    last_row = int((lattice.down - lattice.phase_y) // BLOCK)
    found = set()
    for j, i in raw.blocks:
        for dj in (-1, 0, 1):
            for di in (-1, 0, 1):
                row, column = j + dj, i + di
                if 0 <= row <= last_row:
                    found.add((row, column % columns if columns else column))
    if columns > 1:  # the last one is narrow: what is beside its neighbour is beside it as well
        found |= {(j, 0) for j, i in found if i == columns - 2}
        found |= {(j, columns - 2) for j, i in found if i == 0}
    return found


def _page(raw: RawLevel, coarser: Coarser | None, j: int, i: int) -> tuple[Heights, Heights | None] | None:
    """Heights and weights of a page's slot."""
    margin = RINGS + 1
    row, column, side = j * PAGE - BEFORE - margin, i * PAGE - BEFORE - margin, SLOT + 2 * margin
    values = raw.window(row, column, side, side)
    there = ~np.isnan(values)
    inner = slice(margin, margin + SLOT)
    if there[inner, inner].all():
        return values[inner, inner].copy(), None
    if not there.any():
        return None
    ring = np.where(there, 0, RINGS + 1)
    for number in range(1, RINGS + 1):
        ring[(ring > number) & (_around((ring < number).astype(np.int8)) > 0)] = number
    base = np.zeros((side, side))
    # Beyond the samples, and at those that are next to it.
    asked = np.flatnonzero((ring <= RINGS) & (_around((ring > 0).astype(np.int8)) > 0))
    if coarser is not None and asked.size:
        base.ravel()[asked] = _coarser_heights(raw.lattice, coarser, row + asked // side, column + asked % side)
    rest = np.where(there, values - base, 0.0)
    for number in range(1, RINGS + 1):
        known = ring < number
        count, total = _around(known.astype(np.float64)), _around(np.where(known, rest, 0.0))
        new = ring == number
        rest[new] = total[new] / count[new]
    weight = np.clip((ring - _WHOLE_RINGS) / (RINGS - 1.0 - _WHOLE_RINGS), 0.0, 1.0)
    weight = 1.0 - weight * weight * (3.0 - 2.0 * weight)
    weight = weight[inner, inner].astype(np.float32)
    if not weight.any():
        return None
    filled = np.where(there, values, base + rest)[inner, inner].astype(np.float32)
    return filled, None if weight.min() == 1.0 else weight


def _coarser_heights(lattice: Lattice, coarser: Coarser, rows: Ints, columns: Ints) -> Floats:
    """At samples (N,): 0 where the coarser level has nothing."""
    latitude, longitude = lattice.place(columns, rows)
    over = np.abs(latitude) > 90.0  # beyond a pole the other side follows
    latitude = np.where(over, np.sign(latitude) * 180.0 - latitude, latitude)
    found = coarser(latitude, np.where(over, longitude + 180.0, longitude))
    return np.where(np.isnan(found), 0.0, found)


def _roughness(raw: RawLevel, j: int, i: int) -> Heights:
    """(ROUGH, ROUGH): rms over squares about nodes of what a [1 2 1] blur takes away; 0 where there are no samples."""
    before, side = ROUGH_SIDE * 5 // 2, ROUGH_SIDE * ROUGH
    values = raw.window(j * PAGE - before - 1, i * PAGE - before - 1, side + 2, side + 2).astype(np.float64)
    blurred = 0.25 * values[:-2] + 0.5 * values[1:-1] + 0.25 * values[2:]
    blurred = 0.25 * blurred[:, :-2] + 0.5 * blurred[:, 1:-1] + 0.25 * blurred[:, 2:]
    power = (values[1:-1, 1:-1] - blurred) ** 2
    there = ~np.isnan(power)
    squares = ROUGH, ROUGH_SIDE, ROUGH, ROUGH_SIDE
    total = np.where(there, power, 0.0).reshape(squares).sum(axis=(1, 3))
    count = there.reshape(squares).sum(axis=(1, 3))
    return np.sqrt(total / np.maximum(count, 1)).astype(np.float32)


def _around(values: NDArray[Any]) -> NDArray[Any]:
    """Sums over squares of 3 x 3."""
    wide = np.pad(values, 1)
    rows = wide[:-2] + wide[1:-1] + wide[2:]
    return rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:]


def polar_of(raw: RawLevel) -> Floats:
    """Height and weight at both poles: the mean of the row next to it, if all of it is there."""
    lattice, found = raw.lattice, np.zeros((2, 2))
    if lattice.mercator or not lattice.period:
        return found
    rows = 0, round(lattice.down - 2.0 * lattice.phase_y)
    for k, row in enumerate(rows):
        values = raw.window(row, 0, 1, lattice.period)[0].astype(np.float64)
        if not np.isnan(values).any():
            found[k] = values.mean(), 1.0
    return found
