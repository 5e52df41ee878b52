"""A smooth line above the ground along a path, so that a scripted camera does not bounce over every stone."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class HeightLike(Protocol):
    """What flight needs of a height field: metres above the reference sphere at unit directions (N, 3) -> (N,)."""

    def height(self, directions: Array, /) -> Array: ...


class GroundProfile:
    """The envelope of ground (and water) heights along a track: never below them, and continuous in time.

    ``track(times_s) -> (N, 3)`` gives unit directions. The envelope is a running maximum over ``window_s`` on both
    sides, then a running mean over half of it. Both windows shrink towards the ends of the path, so that the envelope
    meets the true ground there: a path that ends at 2 m ends at 2 m. Cost: one batch of ``samples`` heights.
    """

    def __init__(
        self,
        track: Callable[[Array], Array],
        duration_s: float,
        field: HeightLike,
        *,
        sea_level_m: float | None = None,
        window_s: float = 4.0,
        samples: int = 2048,
    ) -> None:
        self.times_s = np.linspace(0.0, duration_s, samples)
        ground = np.asarray(field.height(track(self.times_s)), dtype=np.float64)
        if sea_level_m is not None:
            ground = np.maximum(ground, sea_level_m)
        reach_s = np.minimum(window_s, np.minimum(self.times_s, duration_s - self.times_s))
        self.heights_m = _running_mean(_running_maximum(ground, self.times_s, reach_s), self.times_s, 0.5 * reach_s)
        self.slopes_m_s = np.gradient(self.heights_m, self.times_s)

    def height(self, time_s: float) -> float:
        """The envelope in m above the reference sphere; a cubic through the samples, with continuous slope."""
        step = self.times_s[1]
        index = int(np.clip(time_s / step, 0, len(self.times_s) - 2))
        x = min(max(time_s / step - index, 0.0), 1.0)
        h0, h1 = float(self.heights_m[index]), float(self.heights_m[index + 1])
        m0, m1 = float(self.slopes_m_s[index]) * step, float(self.slopes_m_s[index + 1]) * step
        return h0 + x * (m0 + x * (3.0 * (h1 - h0) - 2.0 * m0 - m1 + x * (2.0 * (h0 - h1) + m0 + m1)))


def _bounds(times_s: Array, reach_s: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    first = np.searchsorted(times_s, times_s - reach_s - 1e-9)
    last = np.searchsorted(times_s, times_s + reach_s + 1e-9)
    return first, np.maximum(last, first + 1)


def _running_maximum(values: Array, times_s: Array, reach_s: Array) -> Array:
    first, last = _bounds(times_s, reach_s)
    return np.array([values[a:b].max() for a, b in zip(first, last, strict=True)])


def _running_mean(values: Array, times_s: Array, reach_s: Array) -> Array:
    first, last = _bounds(times_s, reach_s)
    return np.array([values[a:b].mean() for a, b in zip(first, last, strict=True)])
