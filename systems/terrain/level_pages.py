"""What is known on the GPU of the pages of one level that streams: what they weigh, and where they lie."""

from __future__ import annotations

from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from .real_wanted import PageReach, ReachedLevel

__all__ = ["LevelPages"]

Ints = NDArray[np.int64]
P = TypeVar("P")
P_co = TypeVar("P_co", covariant=True)


class _Level(ReachedLevel, Protocol[P_co]):
    def page(self, number: int, ahead: bool = False) -> P_co | None: ...

    def empty(self, numbers: Ints) -> NDArray[np.bool_]: ...


class LevelPages(Generic[P]):
    """Of one level: how much pages (P,) weigh, what they shall, whether they are wanted and since which frame no more,
    and their slots (P, 2), -1: none."""

    def __init__(self, level: _Level[P], reach: PageReach) -> None:
        count = len(level.where)
        self.level, self.reach = level, reach
        self.weight = np.zeros(count, np.float32)
        self.target = np.zeros(count, np.float32)
        self.wanted = np.zeros(count, np.bool_)
        self.last = np.zeros(count, np.int64)
        self.slots = np.full((count, 2), -1, np.int64)
        self._columns = -(-level.lattice.period // reach.side)

    @property
    def there(self) -> Ints:
        """Pages that have slots."""
        return np.flatnonzero(self.slots[:, 0] >= 0)

    @property
    def moving(self) -> Ints:
        """Pages that fade."""
        return np.flatnonzero(self.weight != self.target)

    def around(self, pages: Ints) -> Ints:
        """(N, 3, 3) numbers of pages and of those beside them, -1: none."""
        where, step = self.level.where[pages], np.arange(-1, 2)
        row, column = where[:, 0, None, None] + step[:, None], where[:, 1, None, None] + step
        row, column = np.broadcast_arrays(row, column % self._columns if self._columns else column)
        return np.where(row >= 0, self.level.numbers(np.maximum(row, 0), column), -1)

    def corners(self, pages: Ints) -> NDArray[np.float32]:
        """(N, 4): what pages weigh north-west, north-east, south-west, south-east: the least of those around; where
        there are none, nothing is missing."""
        around = self.around(pages)
        weight = np.where(around >= 0, self.weight[np.maximum(around, 0)], np.float32(1.0))
        both = np.minimum(weight[:, :, :2], weight[:, :, 1:])
        return np.minimum(both[:, :2], both[:, 1:]).reshape(-1, 4).astype(np.float32)
