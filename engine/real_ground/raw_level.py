"""Samples of one level of a raster around the world, as blocks: only those that hold any height are kept."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from .lattice import Lattice

__all__ = ["BLOCK", "RawLevel", "coarser_block", "factor_of", "means_of"]

Heights = NDArray[np.float32]

BLOCK = 120
"""Samples a side."""


def factor_of(lattice: Lattice) -> int:
    """How many samples of a level make one of the next: four, or what divides the columns around the world; 0: no
    factor does."""
    return next((f for f in (4, 5, 3, 2) if lattice.period % f == 0), 0)  # 0 % 4 is 0: those never meet again


class RawLevel:
    """Heights in metres, NaN where there is none."""

    def __init__(self, lattice: Lattice) -> None:
        self.lattice = lattice
        self.blocks: dict[tuple[int, int], Heights] = {}
        """By (row, column) of blocks."""
        self.counts: dict[tuple[int, int], NDArray[np.uint16]] = {}
        """Of how many samples each is a sum, until `finish`."""
        half = 2.0 * lattice.phase_y
        self._mirrored = not lattice.mercator and lattice.period % 2 == 0 and lattice.period > 0
        self._mirrored &= abs(half - round(half)) < 1e-9 and abs(lattice.down - round(lattice.down)) < 1e-6
        self._half = round(half)

    def place(self, values: Heights, column: int, row: int) -> None:
        """Put samples where there are none yet; the first one is at (column, row)."""
        for (j, i), inner, outer in self._parts(values.shape, column, row):
            block = self.blocks.get((j, i))
            if block is None:
                if np.isnan(values[inner]).all():
                    continue
                block = self.blocks[j, i] = np.full((BLOCK, BLOCK), np.nan, np.float32)
            part = block[outer]
            np.copyto(part, values[inner], where=np.isnan(part))

    def add(self, sums: NDArray[np.float32], counts: NDArray[np.uint16], column: int, row: int) -> None:
        """Add up blocks of finer samples: their sums, and how many each is of. `finish` makes means of them."""
        for (j, i), inner, outer in self._parts(sums.shape, column, row):
            if not counts[inner].any():
                continue
            block = self.blocks.get((j, i))
            if block is None:
                block = self.blocks[j, i] = np.zeros((BLOCK, BLOCK), np.float32)
                self.counts[j, i] = np.zeros((BLOCK, BLOCK), np.uint16)
            block[outer] += sums[inner]
            self.counts[j, i][outer] += counts[inner]

    def finish(self) -> None:
        """Means in place of sums."""
        for key, counts in self.counts.items():
            with np.errstate(invalid="ignore", divide="ignore"):
                self.blocks[key] = np.where(counts > 0, self.blocks[key] / counts, np.float32(np.nan))
        self.counts.clear()

    def _parts(
        self, shape: tuple[int, ...], column: int, row: int
    ) -> Iterator[tuple[tuple[int, int], tuple[slice, slice], tuple[slice, slice]]]:
        """(block, slices of an array at (column, row), slices of the block) of all blocks that the array touches."""
        period = self.lattice.period
        for j, rows, block_rows in _cut(row, shape[0]):
            start = 0
            while start < shape[1]:  # pieces that do not cross the date line
                at = column + start
                length = shape[1] - start
                if period:
                    at %= period
                    length = min(length, period - at)
                for i, columns, block_columns in _cut(at, length):
                    inner = slice(columns.start + start, columns.stop + start)
                    yield (j, i), (rows, inner), (block_rows, block_columns)
                start += length

    def window(self, row: int, column: int, height: int, width: int) -> Heights:
        """Samples (height, width) from (row, column) on: around the world, and across the poles."""
        out = np.full((height, width), np.nan, np.float32)
        last = round(self.lattice.down) - self._half  # of rows: the one at or next to the south pole
        if not self._mirrored or (row >= 0 and row + height - 1 <= last):
            self._fill(out, row, column)
            return out
        for k in range(height):
            r, c = row + k, column
            if r < 0:
                r, c = -r - self._half, c + self.lattice.period // 2
            elif r > last:
                r, c = 2 * round(self.lattice.down) - self._half - r, c + self.lattice.period // 2
            self._fill(out[k : k + 1], r, c)
        return out

    def block(self, key: tuple[int, int]) -> Heights | None:
        """The block at (row, column) of blocks, None where there is none."""
        return self.blocks.get(key)

    def _fill(self, out: Heights, row: int, column: int) -> None:
        for key, inner, outer in self._parts(out.shape, column, row):
            block = self.block(key)
            if block is not None:
                out[inner] = block[outer]

    def coarser(self, factor: int) -> RawLevel:
        """The level of means of factor x factor samples, of those that there are."""
        found = RawLevel(self.lattice.coarser(factor))
        for j, i in {(j // factor, i // factor) for j, i in self.blocks}:
            found.blocks[j, i] = coarser_block(self, factor, j, i)
        return found

    def plain(self, row: int, column: int, side: int) -> Heights:
        """As window, where nothing is beyond the date line."""
        out = np.full((side, side), np.nan, np.float32)
        for j, rows, block_rows in _cut(row, side):
            for i, columns, block_columns in _cut(column, side):
                block = self.block((j, i))
                if block is not None:
                    out[rows, columns] = block[block_rows, block_columns]
        return out


def coarser_block(raw: RawLevel, factor: int, j: int, i: int) -> Heights:
    """Block (j, i) of the level of means of factor x factor samples, of those that there are."""
    side = BLOCK * factor
    return means_of(raw.plain(j * side, i * side, side), factor)


def means_of(fine: Heights, factor: int) -> Heights:
    """Means of factor x factor samples, of those that there are."""
    there = ~np.isnan(fine)
    counts = there.reshape(BLOCK, factor, BLOCK, factor).sum(axis=(1, 3))
    sums = np.where(there, fine, 0.0).reshape(BLOCK, factor, BLOCK, factor).sum(axis=(1, 3), dtype=np.float64)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(counts > 0, sums / counts, np.nan).astype(np.float32)


def _cut(start: int, length: int) -> Iterator[tuple[int, slice, slice]]:
    """(block, slice of the run, slice of the block) of a run of samples."""
    at = start
    while at < start + length:
        block = at // BLOCK
        end = min((block + 1) * BLOCK, start + length)
        yield block, slice(at - start, end - start), slice(at - block * BLOCK, end - block * BLOCK)
        at = end
