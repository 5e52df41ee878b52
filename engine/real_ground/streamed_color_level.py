"""A level of pictures whose pages are in memory only as far as they were asked for last."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .color_ground import SLOT, ColorPages, taps_of_pixels
from .color_level import Pixels
from .lattice import Lattice
from .page_pool import PagePool, PageSource, PooledPages

__all__ = ["COLOR_SLOT_BYTES", "ColorPool", "StreamedColorLevel", "streamed_color_level"]

Ints = NDArray[np.int64]

COLOR_SLOT_BYTES = 4 * SLOT * SLOT
_HELD = 1


class ColorPool(PagePool):
    """Slots of pixels."""

    def __init__(self, most_bytes: int) -> None:
        super().__init__(most_bytes, COLOR_SLOT_BYTES)
        self.pixels = np.zeros((self.slots, SLOT, SLOT, 4), np.uint8)  # untouched memory costs nothing


class StreamedColorLevel(PooledPages[Pixels, ColorPool], ColorPages):
    """As ColorPages, with pages of a pool. Its own array of pixels is empty."""

    @property
    def nbytes(self) -> int:
        return 0

    def got(self, slots: Ints) -> Pixels:
        return self.pool.pixels[int(slots[0])].copy()

    def put(self, number: int, found: Pixels | None, kind: int) -> tuple[int, Pixels] | None:
        if found is not None:
            return _HELD, found
        # Where a tile has broken meanwhile nothing is left of what was there.
        return None if kind != _HELD else (_HELD, np.zeros((SLOT, SLOT, 4), np.uint8))

    def write(self, number: int, found: Pixels, slots: list[int]) -> None:
        self.pool.pixels[slots[0]] = found

    # -- what is asked of pages ----------------------------------------------------------------------------------------

    def there(self, page: Ints) -> NDArray[np.bool_]:
        return self.known_there(page)

    def taps(self, page: Ints, j: Ints, i: Ints) -> NDArray[np.uint8]:
        out = np.empty((2, 2, len(page), 4), np.uint8)

        def look(at: Ints) -> None:
            out[:, :, at] = taps_of_pixels(self.pool.pixels, self.slots_of(0, page[at]), j[at], i[at])

        self.with_pages(page, look)
        return out


def streamed_color_level(
    lattice: Lattice, where: Ints, source: PageSource[Pixels], pool: ColorPool
) -> StreamedColorLevel:
    """A level without any page yet. where: (P, 2) row and column of those that there may be, sorted."""
    level = StreamedColorLevel(lattice, np.zeros((0, SLOT, SLOT, 4), np.uint8), where)
    level.begin_pages(source, pool, 1)
    return level
