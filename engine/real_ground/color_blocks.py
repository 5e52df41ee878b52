"""Blocks of pixels made when they are asked for: from tiles, with what goes on beyond them, and means of finer ones.

As ColorLevel has them, byte by byte, but only those asked for last are in memory.
"""

from __future__ import annotations

import logging
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from .block_keys import among, names_of
from .color_files import read_color_tile
from .color_level import SIDE, ColorLevel, Pixels, coarser_pixels, finer_keys
from .color_margins import block_with_margins
from .color_unlit import Relief, SunFit
from .found import TileError
from .least_used import LeastUsed
from .tile_blocks import TilePart, parts_of, tiles_by_square
from .tile_index import TileSet
from .tile_scan import BlockFile

__all__ = ["LevelBlocks", "MarginBlocks", "MeanPixels", "PixelFile", "TilePixels"]

log = logging.getLogger(__name__)

Ints = NDArray[np.int64]
Key = tuple[int, int]

_BLOCKS_KEPT = 96
"""6 MB a level: a square of pages, with those around."""
_DECODED_BYTES = 32 << 20


class PixelFile(BlockFile):
    """Blocks of pixels in a file."""

    shape = (SIDE, SIDE, 4)
    kind = np.uint8


class TilePixels(ColorLevel):
    """The pixels of a set's files. Of places that several tiles have, the first one's. convert: colours as files hold
    them, (..., 4), into what levels hold. what: for warnings. `blocks` stays empty."""

    def __init__(self, tiles: TileSet, convert: Callable[[Pixels], Pixels], what: str) -> None:
        super().__init__(tiles.lattice)
        self.tiles, self._convert, self._what = tiles, convert, what
        self._by_square = tiles_by_square(tiles, SIDE)
        self._decoded: LeastUsed[int, Pixels]
        self._kept: LeastUsed[Key, Pixels | None]
        self.forget()
        self.broken: set[int] = set()
        """Numbers of tiles that could not be read: there are none there."""
        self._sun: tuple[SunFit, Relief, float] | None = None

    def take_out_sun(self, fit: SunFit, relief: Relief, strength: float) -> None:
        """Of all blocks from now on."""
        self._sun = fit, relief, strength
        self.forget()

    def forget(self) -> None:
        """Let go of what was asked for last."""
        self._decoded = LeastUsed(_DECODED_BYTES, self._decode, lambda pixels: pixels.nbytes)
        self._kept = LeastUsed(_BLOCKS_KEPT, self._make)

    def block(self, key: Key) -> Pixels | None:
        return self._kept.get(key)

    def _make(self, key: Key) -> Pixels | None:
        out = None
        for each in parts_of(self.tiles, self._by_square, SIDE, key):
            pixels = None if each.number in self.broken else self._part(each)
            if pixels is None or not pixels[..., 3].any():
                continue
            if out is None:
                out = np.zeros((SIDE, SIDE, 4), np.uint8)
            part = out[each.block]
            part[...] = np.where(part[..., 3:] > 0, part, pixels)
        if out is None or self._sun is None:
            return out
        fit, relief, strength = self._sun
        return fit.unlit(out, key, relief, strength)

    def _part(self, part: TilePart) -> Pixels | None:
        number = part.number
        try:
            file, where = self.tiles.tile(number)
            if where.warped:  # any window of it may be read
                return self._convert(read_color_tile(file, where.window(*part.inside)))
            return self._decoded.get(number)[part.inside]
        except (TileError, OSError) as error:
            if number not in self.broken:
                self.broken.add(number)
                log.warning("%s: %s (left out)", self._what, error)
            return None

    def _decode(self, number: int) -> Pixels:
        return self._convert(read_color_tile(*self.tiles.tile(number)))


class LevelBlocks(ColorLevel):
    """Blocks as levels have them, with rows next to poles as they have to be. `blocks` stays empty."""

    def __init__(self, level: ColorLevel, there: Ints) -> None:
        """level: of which only the lattice counts. there: blocks (N, 2) that may have pixels, but for those of
        `polar`."""
        super().__init__(level.lattice)
        self._there = np.sort(names_of(there))
        self.polar: dict[int, Pixels] = {}
        self.use_polar({})

    def use_polar(self, rows: dict[int, Pixels]) -> None:
        """Rows of ColorLevel.polar_rows, in place of what is there."""
        self.polar = rows
        self._kept: LeastUsed[Key, Pixels | None] = LeastUsed(_BLOCKS_KEPT, self._whole)

    def block(self, key: Key) -> Pixels | None:
        return self._kept.get(key)

    def block_rows(self) -> set[int]:
        return set(np.unique(self._there >> 32).tolist())  # see names_of

    def make(self, key: Key) -> Pixels | None:
        """The block without rows next to poles, None where it has no pixel."""
        raise NotImplementedError

    def finished(self, key: Key, block: Pixels | None) -> Pixels | None:
        """With rows next to poles."""
        j, i = key
        rows = [row for row in self.polar if row // SIDE == j]
        if rows:
            block = np.zeros((SIDE, SIDE, 4), np.uint8) if block is None else block.copy()
            for row in rows:
                part = self.polar[row][i * SIDE : (i + 1) * SIDE]
                block[row - j * SIDE, : len(part)] = part
        return block

    def may_have(self, key: Key) -> bool:
        """Whether a block may have pixels."""
        return self._among(key) or any(row // SIDE == key[0] for row in self.polar)

    def _among(self, key: Key) -> bool:
        return bool(among(names_of(np.array([key])), self._there)[0])

    def _whole(self, key: Key) -> Pixels | None:
        return self.finished(key, self.make(key) if self._among(key) else None)

    def polar_keys(self) -> Ints:
        """(N, 2) blocks of the rows next to poles."""
        columns = -(-self.lattice.period // SIDE)
        keys = [(j, i) for j in sorted({row // SIDE for row in self.polar}) for i in range(columns)]
        return np.array(keys, dtype=np.int64).reshape(-1, 2)


class MarginBlocks(LevelBlocks):
    """Those of a set's finest level: of tiles, with what goes on beyond them."""

    def __init__(self, raw: ColorLevel, there: Ints) -> None:
        super().__init__(raw, there)
        self._raw = raw

    def make(self, key: Key) -> Pixels | None:
        return block_with_margins(self._raw, key)


class MeanPixels(LevelBlocks):
    """Means of factor x factor pixels of a finer level. stored: blocks that were kept before, with all their rows."""

    def __init__(self, finer: ColorLevel, factor: int, there: Ints, stored: PixelFile) -> None:
        super().__init__(ColorLevel(finer.lattice.coarser(factor)), there)
        self._finer, self._factor, self.stored = finer, factor, stored

    def make(self, key: Key) -> Pixels | None:
        kept = self.stored.read(key)
        if kept is not None:
            return kept
        return coarser_pixels([self._finer.block(each) for each in finer_keys(self._factor, *key)], self._factor)
