"""A level whose pages are in memory only as far as they were asked for last.

Whoever asks for a height gets the page's own, whether it is in memory or has to be read: answers never depend on what
was asked before.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from threading import Lock, RLock

import numpy as np
from numpy.typing import NDArray

from .lattice import Lattice
from .page_files import SQUARE, PageFiles
from .pages import ROUGH, SLOT, STEEP_BLOCKS, Coarser, MadePage, PageLevel, made_page, page_slopes, taps_of
from .raw_level import RawLevel

__all__ = ["SLOT_BYTES", "PagePool", "PageSource", "StreamedLevel", "streamed_level"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SLOT_BYTES = 4 * (SLOT * SLOT + ROUGH * ROUGH + STEEP_BLOCKS * STEEP_BLOCKS)
_FEWEST = 16
_UNKNOWN, _EMPTY, _PLAIN, _WEIGHED = -1, 0, 1, 2


@dataclass(frozen=True, eq=False)
class PageSource:
    """Where a level's pages come from. name: of its files. whole: whether no tile was found broken so far."""

    name: str
    raw: RawLevel
    coarser: Coarser | None
    files: PageFiles
    whole: Callable[[], bool]
    _making: tuple[Lock, ...] = field(default_factory=lambda: tuple(Lock() for _ in range(16)))

    def page(self, j: int, i: int, ahead: bool = False) -> MadePage | None:
        """The page in row j and column i of pages, None where nothing is. ahead: those around will be asked for,
        too: all of its square is made and kept."""
        known, found = self.files.load(self.name, j, i)
        if known:
            return found
        if not ahead or not self.files.keeps:
            return made_page(self.raw, self.coarser, j, i)
        with self._making[hash((j // SQUARE, i // SQUARE)) % len(self._making)]:
            known, found = self.files.load(self.name, j, i)  # another thread may have made it meanwhile
            return found if known else self._square(j, i)

    def _square(self, j: int, i: int) -> MadePage | None:
        first_j, first_i = j // SQUARE * SQUARE, i // SQUARE * SQUARE
        made = {
            (row, column): page
            for row in range(first_j, first_j + SQUARE)
            for column in range(first_i, first_i + SQUARE)
            if (page := made_page(self.raw, self.coarser, row, column)) is not None
        }
        if self.whole():
            self.files.save(self.name, j, i, made)
        return made.get((j, i))


class PagePool:
    """Slots for pages of all levels that stream, and what was used longest ago makes room. most_bytes: of all."""

    def __init__(self, most_bytes: int) -> None:
        self.slots = max(most_bytes // SLOT_BYTES, _FEWEST)
        # Untouched memory costs nothing.
        self.samples = np.zeros((self.slots, SLOT, SLOT), np.float32)
        self.roughness = np.zeros((self.slots, ROUGH, ROUGH), np.float32)
        self.steep = np.zeros((self.slots, STEEP_BLOCKS, STEEP_BLOCKS), np.float32)
        self.lock = RLock()
        self._used = np.zeros(self.slots, np.int64)
        self._clock = 0
        self._owner: list[tuple[StreamedLevel, int] | None] = [None] * self.slots
        self._free = list(range(self.slots - 1, -1, -1))
        self.loads = 0
        """Pages taken in so far."""

    @property
    def nbytes(self) -> int:
        """Of what is in use."""
        return (self.slots - len(self._free)) * SLOT_BYTES

    def use(self, slots: Ints) -> None:
        """These are asked for now."""
        self._clock += 1
        self._used[slots] = self._clock

    def take(self, level: StreamedLevel, page: int, count: int) -> list[int]:
        """Slots for a page that comes now."""
        self._clock += 1
        while len(self._free) < count:
            self._make_room()
        found = [self._free.pop() for _ in range(count)]
        for slot in found:
            self._owner[slot] = level, page
            self._used[slot] = self._clock
        return found

    def _make_room(self) -> None:
        """An eighth of all at once: looking for it costs more than a page."""
        taken = np.array([slot for slot, owner in enumerate(self._owner) if owner is not None])
        late = taken[np.argsort(self._used[taken], kind="stable")[: max(self.slots // 8, 2)]]
        for slot in late.tolist():
            owner = self._owner[slot]
            if owner is not None:
                for each in owner[0].let_go(owner[1]):
                    self._owner[each] = None
                    self._free.append(each)


class StreamedLevel(PageLevel):
    """As PageLevel, with pages of a pool. Its own arrays of heights, weights and roughness are empty."""

    source: PageSource
    pool: PagePool
    steepest_rad: float
    """The largest slope on a planet of radius 1."""
    maybe_weighed: NDArray[np.bool_]
    """(P,): pages that may have weights below 1."""

    def begin(self, source: PageSource, pool: PagePool, steepest_rad: float, maybe_weighed: NDArray[np.bool_]) -> None:
        """Where pages come from and go to."""
        vars(self).update(
            source=source,
            pool=pool,
            steepest_rad=steepest_rad,
            maybe_weighed=maybe_weighed,
            _slot=np.full((2, len(self.where)), -1, np.int64),
            _kind=np.full(len(self.where), _UNKNOWN, np.int8),
        )

    _slot: Ints
    _kind: NDArray[np.int8]

    @property
    def nbytes(self) -> int:
        return 0

    def page(self, number: int, ahead: bool = False) -> MadePage | None:
        """A page by itself, None where nothing is; it is taken into the pool, too. Any thread may ask."""
        with self.pool.lock:
            held = self._held(number)
        if held is not None:
            return held
        found = self._read(number, ahead)
        with self.pool.lock:
            self._take(number, found)
        return found

    def empty(self, numbers: Ints) -> NDArray[np.bool_]:
        """Which of pages (N,) are known to have nothing."""
        return self._kind[numbers] == _EMPTY

    def _read(self, number: int, ahead: bool) -> MadePage | None:
        j, i = (int(v) for v in self.where[number])
        return self.source.page(j, i, ahead)

    def _held(self, number: int) -> MadePage | None:
        heights, weights = self._slot[:, number].tolist()
        if heights < 0:
            return None
        samples, pool = self.pool.samples, self.pool
        pool.use(self._slot[self._slot[:, number] >= 0, number])
        return MadePage(
            samples[heights].copy(), samples[weights].copy() if weights >= 0 else None, pool.roughness[heights].copy()
        )

    def _take(self, number: int, found: MadePage | None) -> None:
        if self._slot[0, number] >= 0:
            return
        if found is None and self._kind[number] == _UNKNOWN:
            self._kind[number] = _EMPTY
            return
        if found is None:  # its tile has broken meanwhile
            none = np.zeros((SLOT, SLOT), np.float32)
            found = MadePage(none, none, np.zeros((ROUGH, ROUGH), np.float32))
        elif found.weights is None and self._kind[number] == _WEIGHED:
            found = MadePage(found.heights, np.ones((SLOT, SLOT), np.float32), found.roughness)
        pool = self.pool
        slots = pool.take(self, number, 1 if found.weights is None else 2)
        pool.loads += 1
        pool.samples[slots[0]], pool.roughness[slots[0]] = found.heights, found.roughness
        pool.steep[slots[0]] = page_slopes(self.lattice, found.heights[None], self.where[number][None], 1.0)[0]
        if found.weights is not None:
            pool.samples[slots[1]] = found.weights
        self._slot[: len(slots), number] = slots
        self._kind[number] = _PLAIN if found.weights is None else _WEIGHED

    def let_go(self, number: int) -> list[int]:
        """The pool wants the page's slots: these."""
        slots = [slot for slot in self._slot[:, number].tolist() if slot >= 0]
        self._slot[:, number] = -1
        return slots

    def _with(self, page: Ints, look: Callable[[Ints], None]) -> None:
        """Call look(at) for parts of pages (N,), whose pages are in the pool meanwhile; not of those that are empty."""
        names, of = np.unique(page, return_inverse=True)
        of = of.ravel()
        with self.pool.lock:
            here = self._slot[0, names] >= 0
            slots = self._slot[:, names]
            self.pool.use(slots[slots >= 0])
            if here.any():
                look(np.flatnonzero(here[of]))
        for n in np.flatnonzero(~here & (self._kind[names] != _EMPTY)).tolist():
            number = int(names[n])
            found = self._read(number, False)
            with self.pool.lock:
                self._take(number, found)
                if self._slot[0, number] >= 0:
                    look(np.flatnonzero(of == n))

    # -- what is asked of pages ----------------------------------------------------------------------------------------

    def there(self, page: Ints) -> NDArray[np.bool_]:
        found: NDArray[np.bool_] = page >= 0
        unknown = np.unique(page[found & (self._kind[page] == _UNKNOWN)])
        if len(unknown):
            self._with(unknown, lambda at: None)
        return found & (self._kind[page] != _EMPTY)

    def weighed(self, page: Ints) -> Ints:
        return np.flatnonzero(self._kind[page] == _WEIGHED)

    def height_taps(self, page: Ints, j: Ints, i: Ints) -> Floats:
        return self._taps(self.pool.samples, 0, page, j, i)

    def weight_taps(self, page: Ints, j: Ints, i: Ints) -> Floats:
        return self._taps(self.pool.samples, 1, page, j, i)

    def rough_taps(self, page: Ints, j: Ints, i: Ints) -> Floats:
        return self._taps(self.pool.roughness, 0, page, j, i)

    def _taps(self, values: NDArray[np.float32], which: int, page: Ints, j: Ints, i: Ints) -> Floats:
        out = np.empty((4, 4, len(page)))

        def look(at: Ints) -> None:
            out[:, :, at] = taps_of(values, self._slot[which, page[at]], j[at], i[at])

        self._with(page, look)
        return out

    def steep_at(self, block: Ints, radius_m: float) -> Floats:
        out = np.empty(block.shape[1])

        def look(at: Ints) -> None:
            out[at] = self.pool.steep[self._slot[0, block[0, at]], block[1, at], block[2, at]]

        self._with(block[0], look)
        return out / radius_m

    def steepest(self, radius_m: float) -> float:
        return self.steepest_rad / radius_m


def streamed_level(lattice: Lattice, where: Ints, polar: Floats, finest: bool) -> StreamedLevel:
    """A level without any page yet; `begin` says where they come from."""
    none, few = np.zeros((0, SLOT, SLOT), np.float32), np.zeros((0, ROUGH, ROUGH), np.float32)
    return StreamedLevel(lattice, none, none, np.zeros(0, np.int64), where, polar, few, finest)
