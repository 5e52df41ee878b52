"""A level of heights whose pages are in memory only as far as they were asked for last."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .lattice import Lattice
from .page_pool import PagePool, PageSource, PooledPages
from .pages import ROUGH, SLOT, STEEP_BLOCKS, MadePage, PageLevel, page_slopes, taps_of

__all__ = ["SLOT_BYTES", "HeightPool", "StreamedLevel", "streamed_level"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SLOT_BYTES = 4 * (SLOT * SLOT + ROUGH * ROUGH + STEEP_BLOCKS * STEEP_BLOCKS)
_PLAIN, _WEIGHED = 1, 2


class HeightPool(PagePool):
    """Slots of heights or weights."""

    def __init__(self, most_bytes: int) -> None:
        super().__init__(most_bytes, SLOT_BYTES)
        # Untouched memory costs nothing.
        self.samples = np.zeros((self.slots, SLOT, SLOT), np.float32)
        self.roughness = np.zeros((self.slots, ROUGH, ROUGH), np.float32)
        self.steep = np.zeros((self.slots, STEEP_BLOCKS, STEEP_BLOCKS), np.float32)


class StreamedLevel(PooledPages[MadePage, HeightPool], PageLevel):
    """As PageLevel, with pages of a pool. Its own arrays of heights, weights and roughness are empty."""

    steepest_rad: float
    """The largest slope on a planet of radius 1."""
    maybe_weighed: NDArray[np.bool_]
    """(P,): pages that may have weights below 1."""

    def begin(
        self, source: PageSource[MadePage], pool: HeightPool, steepest_rad: float, maybe_weighed: NDArray[np.bool_]
    ) -> None:  # fmt: skip
        """Where pages come from and go to."""
        self.begin_pages(source, pool, 2)
        vars(self).update(steepest_rad=steepest_rad, maybe_weighed=maybe_weighed)

    @property
    def nbytes(self) -> int:
        return 0

    # -- pages in slots ------------------------------------------------------------------------------------------------

    def got(self, slots: Ints) -> MadePage:
        heights, weights = slots.tolist()
        samples = self.pool.samples
        return MadePage(
            samples[heights].copy(),
            samples[weights].copy() if weights >= 0 else None,
            self.pool.roughness[heights].copy(),
        )

    def put(self, number: int, found: MadePage | None, kind: int) -> tuple[int, MadePage] | None:
        if found is None and kind not in (_PLAIN, _WEIGHED):
            return None
        if found is None:  # its tile has broken meanwhile
            none = np.zeros((SLOT, SLOT), np.float32)
            found = MadePage(none, none, np.zeros((ROUGH, ROUGH), np.float32))
        elif found.weights is None and kind == _WEIGHED:
            found = MadePage(found.heights, np.ones((SLOT, SLOT), np.float32), found.roughness)
        return _PLAIN if found.weights is None else _WEIGHED, found

    def slots_for(self, kind: int) -> int:
        return 2 if kind == _WEIGHED else 1

    def write(self, number: int, found: MadePage, slots: list[int]) -> None:
        pool = self.pool
        pool.samples[slots[0]], pool.roughness[slots[0]] = found.heights, found.roughness
        pool.steep[slots[0]] = page_slopes(self.lattice, found.heights[None], self.where[number][None], 1.0)[0]
        if found.weights is not None:
            pool.samples[slots[1]] = found.weights

    # -- what is asked of pages ----------------------------------------------------------------------------------------

    def there(self, page: Ints) -> NDArray[np.bool_]:
        return self.known_there(page)

    def weighed(self, page: Ints) -> Ints:
        return np.flatnonzero(self.kinds(page) == _WEIGHED)

    def height_taps(self, page: Ints, j: Ints, i: Ints) -> Floats:
        return self._taps(self.pool.samples, 0, page, j, i)

    def weight_taps(self, page: Ints, j: Ints, i: Ints) -> Floats:
        return self._taps(self.pool.samples, 1, page, j, i)

    def rough_taps(self, page: Ints, j: Ints, i: Ints) -> Floats:
        return self._taps(self.pool.roughness, 0, page, j, i)

    def _taps(self, values: NDArray[np.float32], which: int, page: Ints, j: Ints, i: Ints) -> Floats:
        out = np.empty((4, 4, len(page)))

        def look(at: Ints) -> None:
            out[:, :, at] = taps_of(values, self.slots_of(which, page[at]), j[at], i[at])

        self.with_pages(page, look)
        return out

    def steep_at(self, block: Ints, radius_m: float) -> Floats:
        out = np.empty(block.shape[1])

        def look(at: Ints) -> None:
            out[at] = self.pool.steep[self.slots_of(0, block[0, at]), block[1, at], block[2, at]]

        self.with_pages(block[0], look)
        return out / radius_m

    def steepest(self, radius_m: float) -> float:
        return self.steepest_rad / radius_m


def streamed_level(lattice: Lattice, where: Ints, polar: Floats, finest: bool) -> StreamedLevel:
    """A level without any page yet; `begin` says where they come from."""
    none, few = np.zeros((0, SLOT, SLOT), np.float32), np.zeros((0, ROUGH, ROUGH), np.float32)
    return StreamedLevel(lattice, none, none, np.zeros(0, np.int64), where, polar, few, finest)
