"""SlotPool: which tile lies in which slot of the GPU's memory."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["SlotPool"]

Ints = NDArray[np.int64]


class SlotPool:
    """A fixed number of slots for tiles by key. `keys` (count,): what lies in each slot, 0 for nothing."""

    def __init__(self, count: int) -> None:
        self.count = count
        self.keys: Ints = np.zeros(count, np.int64)
        self._sorted: Ints = np.zeros(0, np.int64)
        self._slots: Ints = np.zeros(0, np.int64)
        self._free = list(range(count - 1, -1, -1))

    @property
    def free(self) -> int:
        """Slots without a tile."""
        return len(self._free)

    def resident(self) -> Ints:
        """Keys of all tiles that have a slot, sorted."""
        return self._sorted

    def slots(self, keys: Ints) -> Ints:
        """The slots of tiles (N,), -1 for those that have none."""
        if not len(self._sorted):
            return np.full(len(keys), -1, np.int64)
        at = np.minimum(np.searchsorted(self._sorted, keys), len(self._sorted) - 1)
        return np.where(self._sorted[at] == keys, self._slots[at], -1)

    def take(self, keys: Ints) -> Ints:
        """Slots for tiles that have none yet; there have to be that many free ones."""
        slots = np.array([self._free.pop() for _ in range(len(keys))], np.int64)
        self.keys[slots] = keys
        self._index()
        return slots

    def drop(self, keys: Ints) -> None:
        """Their slots are free again."""
        slots = self.slots(keys)
        slots = slots[slots >= 0]
        self.keys[slots] = 0
        self._free.extend(slots.tolist())
        self._index()

    def clear(self) -> None:
        """All slots are free."""
        self.drop(self.resident())

    def _index(self) -> None:
        used = np.flatnonzero(self.keys)
        order = np.argsort(self.keys[used])
        self._slots = used[order]
        self._sorted = self.keys[self._slots]
