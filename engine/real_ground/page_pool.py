"""Pages of levels that stream, whatever they hold: slots in memory for those asked for last, and where they come from.

Whoever asks for a page gets it, whether it is in memory or has to be read: answers never depend on what was asked
before.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from threading import Lock, RLock
from typing import Any, Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from .page_files import SQUARE, PageFiles

__all__ = ["PagePool", "PageSource", "PooledPages"]

Ints = NDArray[np.int64]
P = TypeVar("P")
Pool = TypeVar("Pool", bound="PagePool")

_FEWEST = 16
_UNKNOWN, _EMPTY = -1, 0


@dataclass(frozen=True, eq=False)
class PageSource(Generic[P]):
    """Where a level's pages come from. name: of its files. make: the page in a row and a column of pages from tiles,
    None where nothing is. whole: whether no tile was found broken so far."""

    name: str
    make: Callable[[int, int], P | None]
    files: PageFiles[P]
    whole: Callable[[], bool]
    _making: tuple[Lock, ...] = field(default_factory=lambda: tuple(Lock() for _ in range(16)))

    def page(self, j: int, i: int, ahead: bool = False) -> P | None:
        """The page in row j and column i of pages, None where nothing is. ahead: those around will be asked for,
        too: all of its square is made and kept."""
        known, found = self.files.load(self.name, j, i)
        if known:
            return found
        if not ahead or not self.files.keeps:
            return self.make(j, i)
        with self._making[hash((j // SQUARE, i // SQUARE)) % len(self._making)]:
            known, found = self.files.load(self.name, j, i)  # another thread may have made it meanwhile
            return found if known else self._square(j, i)

    def _square(self, j: int, i: int) -> P | None:
        first_j, first_i = j // SQUARE * SQUARE, i // SQUARE * SQUARE
        made = {
            (row, column): page
            for row in range(first_j, first_j + SQUARE)
            for column in range(first_i, first_i + SQUARE)
            if (page := self.make(row, column)) is not None
        }
        if self.whole():
            self.files.save(self.name, j, i, made)
        return made.get((j, i))


class _Owner(Protocol):
    def let_go(self, number: int) -> list[int]: ...


class PagePool:
    """Slots for pages of all levels that stream, and what was used longest ago makes room. most_bytes: of all;
    slot_bytes: of one. Whoever makes one adds the arrays."""

    def __init__(self, most_bytes: int, slot_bytes: int) -> None:
        self.slots = max(most_bytes // slot_bytes, _FEWEST)
        self._slot_bytes = slot_bytes
        self.lock = RLock()
        self._used = np.zeros(self.slots, np.int64)
        self._clock = 0
        self._owner: list[tuple[_Owner, int] | None] = [None] * self.slots
        self._free = list(range(self.slots - 1, -1, -1))
        self.loads = 0
        """Pages taken in so far."""

    @property
    def nbytes(self) -> int:
        """Of what is in use."""
        return (self.slots - len(self._free)) * self._slot_bytes

    def use(self, slots: Ints) -> None:
        """These are asked for now."""
        self._clock += 1
        self._used[slots] = self._clock

    def take(self, level: _Owner, page: int, count: int) -> list[int]:
        """Slots for a page that comes now."""
        self._clock += 1
        while len(self._free) < count:
            self._make_room()
        found = [self._free.pop() for _ in range(count)]
        for slot in found:
            self._owner[slot] = level, page
            self._used[slot] = self._clock
        self.loads += 1
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


class PooledPages(Generic[P, Pool]):
    """What a level does whose pages are in a pool. A level says how a page lies in its slots: `put` and `got`."""

    where: Ints
    source: PageSource[P]
    pool: Pool
    _slot: Ints
    _kind: NDArray[np.int8]

    def begin_pages(self, source: PageSource[P], pool: Pool, slots: int) -> None:
        """Where pages come from and go to. slots: that a page takes at most."""
        state: dict[str, Any] = {
            "source": source,
            "pool": pool,
            "_slot": np.full((slots, len(self.where)), -1, np.int64),
            "_kind": np.full(len(self.where), _UNKNOWN, np.int8),
        }
        vars(self).update(state)  # levels are frozen otherwise

    # -- what a level says ---------------------------------------------------------------------------------------------

    def got(self, slots: Ints) -> P:
        """The page in these slots, its own copy."""
        raise NotImplementedError

    def put(self, number: int, found: P | None, kind: int) -> tuple[int, P] | None:
        """Take a page in: of which kind it is, above 0, and what goes into slots; None: it has nothing. kind: what it
        was before, -1: nobody knows."""
        raise NotImplementedError

    def slots_for(self, kind: int) -> int:
        """Slots of a page of a kind."""
        return 1

    def write(self, number: int, found: P, slots: list[int]) -> None:
        """The page into its slots."""
        raise NotImplementedError

    # ------------------------------------------------------------------------------------------------------------------

    def page(self, number: int, ahead: bool = False) -> P | None:
        """A page by itself, None where nothing is; it is taken into the pool, too. Any thread may ask."""
        with self.pool.lock:
            slots = self._slot[:, number]
            if slots[0] >= 0:
                self.pool.use(slots[slots >= 0])
                return self.got(slots)
        found = self._read(number, ahead)
        with self.pool.lock:
            self._take(number, found)
        return found

    def empty(self, numbers: Ints) -> NDArray[np.bool_]:
        """Which of pages (N,) are known to have nothing."""
        return self._kind[numbers] == _EMPTY

    def _read(self, number: int, ahead: bool) -> P | None:
        j, i = (int(v) for v in self.where[number])
        return self.source.page(j, i, ahead)

    def _take(self, number: int, found: P | None) -> None:
        if self._slot[0, number] >= 0:
            return
        known = self.put(number, found, int(self._kind[number]))
        if known is None:
            self._kind[number] = _EMPTY
            return
        kind, page = known
        slots = self.pool.take(self, number, self.slots_for(kind))
        self.write(number, page, slots)
        self._slot[: len(slots), number] = slots
        self._kind[number] = kind

    def let_go(self, number: int) -> list[int]:
        """The pool wants the page's slots: these."""
        slots = [slot for slot in self._slot[:, number].tolist() if slot >= 0]
        self._slot[:, number] = -1
        return slots

    def with_pages(self, page: Ints, look: Callable[[Ints], None]) -> None:
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

    def slots_of(self, which: int, page: Ints) -> Ints:
        """Slot `which` of pages (N,), within `with_pages`."""
        return self._slot[which, page]

    def known_there(self, page: Ints) -> NDArray[np.bool_]:
        """Which of pages (N,), -1: none, have anything."""
        found: NDArray[np.bool_] = page >= 0
        unknown = np.unique(page[found & (self._kind[page] == _UNKNOWN)])
        if len(unknown):
            self.with_pages(unknown, lambda at: None)
        return found & (self._kind[page] != _EMPTY)

    def kinds(self, page: Ints) -> NDArray[np.int8]:
        """Of pages (N,)."""
        return self._kind[page]
