"""A store of values that are made when they are asked for, and forgotten when others were asked for since."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from threading import Lock
from typing import Generic, TypeVar

__all__ = ["LeastUsed"]

K = TypeVar("K")
V = TypeVar("V")


class LeastUsed(Generic[K, V]):
    """What was asked for last, up to `most` in all. size: of a value. Several threads may make the same value."""

    def __init__(self, most: int, make: Callable[[K], V], size: Callable[[V], int] = lambda value: 1) -> None:
        self._most, self._make, self._size = most, make, size
        self._held: OrderedDict[K, V] = OrderedDict()
        self._taken = 0
        self._lock = Lock()

    def get(self, key: K) -> V:
        """The value, made anew if it is gone."""
        with self._lock:
            if key in self._held:
                self._held.move_to_end(key)
                return self._held[key]
        value = self._make(key)
        with self._lock:
            if key not in self._held:
                self._held[key] = value
                self._taken += self._size(value)
            while self._taken > self._most and len(self._held) > 1:
                self._taken -= self._size(self._held.popitem(last=False)[1])
        return value
