"""Pixels of one level of a picture around the world, as blocks: only those that hold any are kept.

A pixel is four bytes: square roots of its three values times its weight, even steps for the eye, and the weight. So
means of pixels are means of what a picture shows over nothing, and what lies below shows by the rest.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .block_keys import reached_by
from .lattice import Lattice

__all__ = ["SIDE", "ColorLevel", "coarser_pixels", "coded", "decoded", "finer_keys", "near_blocks", "pixel_factor"]

Pixels = NDArray[np.uint8]
Singles = NDArray[np.float32]
Ints = NDArray[np.int64]
Key = tuple[int, int]

SIDE = 126
"""Pixels a side of a block."""
_POLAR_ROWS = 8
"""Rows next to a pole whose pixels, narrow there, are made as wide as they are high."""
_SHARES = (np.arange(256) / 255.0).astype(np.float32)
_SQUARES = _SHARES * _SHARES


def decoded(pixels: Pixels) -> Singles:
    """Values times weight, and the weight: (..., 4)."""
    out = _SQUARES[pixels]
    out[..., 3] = _SHARES[pixels[..., 3]]
    return out


def coded(values: NDArray[Any]) -> Pixels:
    """The inverse of `decoded`, to the nearest step."""
    shares = np.clip(values, 0.0, 1.0)
    np.sqrt(shares[..., :3], out=shares[..., :3])
    return np.rint(255.0 * shares).astype(np.uint8)


def pixel_factor(lattice: Lattice) -> int:
    """How many pixels of a level make one of the next: two, or what divides the columns around the world; 0: no factor
    does."""
    return next((f for f in (2, 3, 5, 7) if lattice.period % f == 0), 0)  # 0 % 2 is 0: those never meet again


class ColorLevel:
    """blocks: pixels (SIDE, SIDE, 4) by (row, column) of blocks."""

    def __init__(self, lattice: Lattice) -> None:
        self.lattice = lattice
        self.blocks: dict[Key, Pixels] = {}
        half = 2.0 * lattice.phase_y
        self._mirrored = not lattice.mercator and lattice.period % 2 == 0 and lattice.period > 0
        self._mirrored &= abs(half - round(half)) < 1e-9 and abs(lattice.down - round(lattice.down)) < 1e-6
        self._half = round(half)

    def place(self, pixels: Pixels, column: int, row: int) -> None:
        """Put pixels where there are none yet; the first one is at (column, row)."""
        rows, columns = self._numbers(row, column, *pixels.shape[:2])
        for key, j, i, inner in _cut(rows, columns):
            part = pixels[np.ix_(j, i)]
            block = self.blocks.get(key)
            if block is None:
                if not part[..., 3].any():
                    continue
                block = self.blocks[key] = np.zeros((SIDE, SIDE, 4), np.uint8)
            before = block[inner]
            block[inner] = np.where(before[..., 3:] > 0, before, part)

    def add(self, values: Singles, column: int, row: int) -> None:
        """Add values times weight, and weights, of parts of pixels. `whole` makes pixels of them."""
        rows, columns = self._numbers(row, column, *values.shape[:2])
        for key, j, i, inner in _cut(rows, columns):
            part = values[np.ix_(j, i)]
            if not part[..., 3].any():
                continue
            block = self.blocks.setdefault(key, np.zeros((SIDE, SIDE, 4), np.uint8))
            total = decoded(block[inner]) + part
            block[inner] = coded(total / np.maximum(total[..., 3:], 1.0))

    def whole(self) -> None:
        """Full weight wherever there is any."""
        for key, block in self.blocks.items():
            values = decoded(block)
            self.blocks[key] = coded(values / np.maximum(values[..., 3:], 0.5 / 255.0))

    def block(self, key: Key) -> Pixels | None:
        """The block at (row, column) of blocks, None where there is none."""
        return self.blocks.get(key)

    def window(self, row: int, column: int, height: int, width: int) -> Pixels:
        """Pixels (height, width, 4) from (row, column) on: around the world, and across the poles."""
        out = np.zeros((height, width, 4), np.uint8)
        rows, columns = self._numbers(row, column, height, width)
        if not self._mirrored:
            self._fill(out, np.arange(height), rows, columns)
            return out
        last = round(self.lattice.down) - self._half  # of rows: the one at or next to the south pole
        over, under = rows < 0, rows > last
        plain = np.flatnonzero(~(over | under))
        self._fill(out, plain, rows[plain], columns)
        beyond = np.flatnonzero(over | under)
        if beyond.size:
            back = np.where(over, -rows - self._half, 2 * round(self.lattice.down) - self._half - rows)[beyond]
            period = self.lattice.period
            self._fill(out, beyond, back, (columns + period // 2) % period)
        return out

    def _fill(self, out: Pixels, at: Ints, rows: Ints, columns: Ints) -> None:
        """Pixels of these rows into rows `at` of the window."""
        for key, j, i, inner in _cut(rows, columns):
            block = self.block(key)
            if block is not None:
                out[np.ix_(at[j], i)] = block[inner]

    def _numbers(self, row: int, column: int, height: int, width: int) -> tuple[Ints, Ints]:
        columns = np.arange(column, column + width)
        return np.arange(row, row + height), columns % self.lattice.period if self.lattice.period else columns

    def coarser(self, factor: int) -> ColorLevel:
        """The level of means of factor x factor pixels."""
        found = ColorLevel(self.lattice.coarser(factor))
        for j, i in sorted({(j // factor, i // factor) for j, i in self.blocks}):
            mean = coarser_pixels([self.block(key) for key in finer_keys(factor, j, i)], factor)
            if mean is not None:
                found.blocks[j, i] = mean
        return found

    def block_rows(self) -> set[int]:
        """Rows of blocks that may have pixels."""
        return {j for j, _ in self.blocks}

    def polar_rows(self) -> dict[int, Pixels]:
        """Rows (period, 4) next to a pole as they have to be: pixels as wide as they are high, means of those along
        the row."""
        lattice, found = self.lattice, {}
        if lattice.mercator or lattice.period < 8:
            return {}
        last = int(np.ceil(lattice.down - lattice.phase_y)) - 1
        there = self.block_rows()
        for k in range(min(_POLAR_ROWS, last // 2)):
            wide = int(lattice.across / (2.0 * np.pi * max(k + lattice.phase_y, 0.25)))
            reach = min(wide // 2, (lattice.period - 1) // 2)
            for row in (k, last - k):
                if row // SIDE not in there:
                    continue
                pixels = self.window(row, 0, 1, lattice.period)[0]
                if reach < 1 or not pixels[:, 3].any():
                    continue
                around = np.concatenate([pixels[-reach - 1 :], pixels, pixels[:reach]])
                sums = np.cumsum(decoded(around).astype(np.float64), axis=0)
                means = (sums[2 * reach + 1 :] - sums[: lattice.period]) / (2.0 * reach + 1.0)
                found[row] = coded(means)
        return found

    def round_poles(self) -> None:
        """Put `polar_rows` in their place."""
        for row, pixels in self.polar_rows().items():
            for key, _, i, inner in _cut(np.array([row]), np.arange(self.lattice.period)):
                block = self.blocks.setdefault(key, np.zeros((SIDE, SIDE, 4), np.uint8))
                block[inner] = pixels[None, i]


def finer_keys(factor: int, j: int, i: int) -> list[Key]:
    """The factor x factor finer blocks of block (j, i), row by row."""
    return [(j * factor + b, i * factor + a) for b in range(factor) for a in range(factor)]


def coarser_pixels(finer: Sequence[Pixels | None], factor: int) -> Pixels | None:
    """Means of factor x factor pixels of the blocks of `finer_keys`; None where there are none."""
    if all(block is None for block in finer):
        return None
    side = SIDE * factor
    fine = np.zeros((side, side, 4), np.uint8)
    for number, block in enumerate(finer):
        if block is not None:
            b, a = divmod(number, factor)
            fine[b * SIDE : (b + 1) * SIDE, a * SIDE : (a + 1) * SIDE] = block
    mean = coded(decoded(fine).reshape(SIDE, factor, SIDE, factor, 4).mean(axis=(1, 3)))
    return mean if mean[..., 3].any() else None


def _cut(rows: Ints, columns: Ints) -> Iterator[tuple[Key, Ints, Ints, tuple[Ints, Ints]]]:
    """(block, which of the rows and of the columns lie in it, and where there) of pixels of all pairs of both."""
    for j in np.unique(rows // SIDE).tolist():
        of_rows = np.flatnonzero(rows // SIDE == j)
        for i in np.unique(columns // SIDE).tolist():
            of_columns = np.flatnonzero(columns // SIDE == i)
            inner = np.ix_(rows[of_rows] - j * SIDE, columns[of_columns] - i * SIDE)
            yield (j, i), of_rows, of_columns, (inner[0], inner[1])


def near_blocks(level: ColorLevel) -> list[Key]:
    """Blocks with pixels, and those around them."""
    keys = np.array(list(level.blocks), dtype=np.int64).reshape(-1, 2)
    return [(j, i) for j, i in reached_by(level.lattice, keys, SIDE).tolist()]
