"""Blocks of samples made when they are asked for: the finest ones from tiles, the others as means of finer ones.

As RawLevel has them, sample by sample, but only those asked for last are in memory.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .found import Found, TileError
from .lattice import Lattice
from .least_used import LeastUsed
from .raw_level import BLOCK, RawLevel, coarser_block
from .tile_files import read_part, read_tile
from .tile_index import TileSet
from .water_mask import water_of

__all__ = ["SUPER", "MeansBlocks", "TileBlocks", "TilePart", "keys_touched", "parts_of", "tiles_by_square"]

log = logging.getLogger(__name__)

Heights = NDArray[np.float32]
Ints = NDArray[np.int64]

SUPER = 4
"""Blocks a side of the squares that tiles are listed by."""
_BLOCKS_KEPT = 160
"""9 MB a level: a few squares of pages, with those around."""
_DECODED_BYTES = 64 << 20


class _Blocks(RawLevel):
    """A level whose blocks are made, by `make`. `blocks` stays empty."""

    def __init__(self, lattice: Lattice) -> None:
        super().__init__(lattice)
        self._kept: LeastUsed[tuple[int, int], Heights | None] = LeastUsed(_BLOCKS_KEPT, self.make)

    def block(self, key: tuple[int, int]) -> Heights | None:
        return self._kept.get(key)

    def make(self, key: tuple[int, int]) -> Heights | None:
        """The block, None where it has no height."""
        raise NotImplementedError


class TileBlocks(_Blocks):
    """The samples of a set's files. Of places that several tiles have, the first one's. what: for warnings."""

    def __init__(self, tiles: TileSet, what: str) -> None:
        super().__init__(tiles.lattice)
        self.tiles, self._what = tiles, what
        self._water = water_of(tiles.folder, what)
        self.by_square = tiles_by_square(tiles, BLOCK)
        """Numbers of the tiles in each square (row, column) of SUPER x SUPER blocks."""
        self._decoded: LeastUsed[int, Heights] = LeastUsed(_DECODED_BYTES, self._decode, lambda values: values.nbytes)
        self.broken: set[int] = set()
        """Numbers of tiles that could not be read: there are none there."""

    def make(self, key: tuple[int, int]) -> Heights | None:
        out = None
        for each in parts_of(self.tiles, self.by_square, BLOCK, key):
            if each.number in self.broken:
                continue
            values = self._part(each.number, *each.inside)
            if values is None or np.isnan(values).all():
                continue
            if out is None:
                out = np.full((BLOCK, BLOCK), np.nan, np.float32)
            part = out[each.block]
            np.copyto(part, values, where=np.isnan(part))
        return out

    def _part(self, number: int, rows: slice, columns: slice) -> Heights | None:
        file, where = self.tiles.tile(number)
        try:
            values = read_part(file, where, rows, columns)
            if values is None:
                values = self._decoded.get(number)[rows, columns]
        except (TileError, OSError) as error:
            if number not in self.broken:
                self.broken.add(number)
                log.warning("%s: %s (left out)", self._what, error)
            return None
        geoid_m = self.tiles.folder.geoid_m
        values = values + np.float32(geoid_m) if geoid_m else values
        if self._water is None:
            return values
        lattice, column, row = where.lattice, where.column + columns.start, where.row + rows.start
        return self._water.lowered(values, Found(lattice, column, row, values.shape[1], values.shape[0]))

    def _decode(self, number: int) -> Heights:
        file, where = self.tiles.tile(number)
        return read_tile(file, where, self.tiles.folder.png)


@dataclass(frozen=True)
class TilePart:
    """What a block has of a tile: the tile's number, and rows and columns in it and in the block."""

    number: int
    inside: tuple[slice, slice]
    block: tuple[slice, slice]


def parts_of(
    tiles: TileSet, by_square: Mapping[tuple[int, int], Sequence[int]], side: int, key: tuple[int, int]
) -> Iterator[TilePart]:
    """Of the block of `side` samples a side at (row, column) of blocks. by_square: of tiles_by_square."""
    (j, i), period = key, tiles.lattice.period
    wide = min(side, period - i * side) if period else side
    for number in by_square.get((j // SUPER, i // SUPER), ()):
        column, row, columns, rows = (int(v) for v in tiles.where[number])
        first, end = max(j * side, row), min((j + 1) * side, row + rows)
        for turn in (-period, 0, period) if period else (0,):
            west, east = max(i * side, column + turn), min(i * side + wide, column + turn + columns)
            if first >= end or west >= east:
                continue
            yield TilePart(
                number,
                (slice(first - row, end - row), slice(west - column - turn, east - column - turn)),
                (slice(first - j * side, end - j * side), slice(west - i * side, east - i * side)),
            )


def tiles_by_square(tiles: TileSet, side: int) -> dict[tuple[int, int], list[int]]:
    """Numbers, ascending, of the tiles that touch each square of SUPER x SUPER blocks of `side` samples a side."""
    found: dict[tuple[int, int], list[int]] = {}
    for number, rows, columns in _touched(tiles, SUPER * side):
        for j in rows:
            for i in columns:
                found.setdefault((j, i), []).append(number)
    return found


def keys_touched(tiles: TileSet, side: int) -> Ints:
    """Blocks (N, 2) of `side` samples a side that tiles touch, sorted."""
    found = {(j, i) for _, rows, columns in _touched(tiles, side) for j in rows for i in columns}
    return np.array(sorted(found), dtype=np.int64).reshape(-1, 2)


def _touched(tiles: TileSet, side: int) -> Iterator[tuple[int, range, set[int]]]:
    """Of each tile its number, and rows and columns of the squares of `side` samples a side that it touches."""
    period = tiles.lattice.period
    for number, (column, row, columns, rows) in enumerate(tiles.where.tolist()):
        across: set[int] = set()
        for turn in (-period, 0, period) if period else (0,):
            west, east = column + turn, column + turn + columns
            if period:
                west, east = max(west, 0), min(east, period)
            if west < east:
                across |= set(range(west // side, (east - 1) // side + 1))
        yield number, range(row // side, (row + rows - 1) // side + 1), across


class MeansBlocks(_Blocks):
    """Means of factor x factor samples of a finer level. stored: a block that was kept before, if it was."""

    def __init__(
        self, finer: RawLevel, factor: int, there: Callable[[tuple[int, int]], bool],
        stored: Callable[[tuple[int, int]], Heights | None],
    ) -> None:  # fmt: skip
        super().__init__(finer.lattice.coarser(factor))
        self._finer, self._factor, self._there, self._stored = finer, factor, there, stored

    def make(self, key: tuple[int, int]) -> Heights | None:
        if not self._there(key):
            return None
        kept = self._stored(key)
        return coarser_block(self._finer, self._factor, *key) if kept is None else kept
