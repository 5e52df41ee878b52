"""What passes cost over the last frames: a ring of numbers, and percentiles. Plain numpy, no ImGui."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .passes import PassTime

__all__ = ["FrameProfile", "Percentiles", "percentiles"]

_FRAMES = 240


@dataclass(frozen=True)
class Percentiles:
    """Of frame times, in ms. worst_share: share of the frames that took more than twice the median."""

    median: float
    p95: float
    p99: float
    worst: float
    worst_share: float


def percentiles(frame_ms: Sequence[float] | NDArray[np.float32]) -> Percentiles | None:
    """None for less than two frames."""
    times = np.asarray(frame_ms, np.float64)
    if times.size < 2:
        return None
    median, p95, p99 = np.percentile(times, (50.0, 95.0, 99.0))
    return Percentiles(float(median), float(p95), float(p99), float(times.max()), float((times > 2.0 * median).mean()))


class FrameProfile:
    """The last frames, pass by pass. `add` one a frame; passes may come and go."""

    def __init__(self, frames: int = _FRAMES) -> None:
        self.frames = frames
        self._rows: dict[str, NDArray[np.float32]] = {}
        self._next = self._count = 0

    def add(self, passes: Iterable[PassTime], gpu: bool) -> None:
        """A frame. gpu: take GPU times (those that are there) instead of the CPU's."""
        for row in self._rows.values():
            row[self._next] = 0.0
        for entry in passes:
            took = (entry.gpu_ms or 0.0) if gpu else entry.cpu_ms
            if entry.skipped or took <= 0.0:
                continue
            row = self._rows.get(entry.name)
            if row is None:
                row = self._rows[entry.name] = np.zeros(self.frames, np.float32)
            row[self._next] = took
        self._next = (self._next + 1) % self.frames
        self._count = min(self._count + 1, self.frames)

    def clear(self) -> None:
        """Forget all, as when times of another kind follow."""
        self._rows.clear()
        self._next = self._count = 0

    def __len__(self) -> int:
        return self._count

    def stacked(self, most: int = 8) -> list[tuple[str, NDArray[np.float32], NDArray[np.float32]]]:
        """(name, lower, upper) of bands to draw on one another, each (frames,), oldest first, in ms: the costliest
        passes from the bottom up, and what is left as "others"."""
        if not self._count:
            return []
        held = [(name, self._ordered(row)) for name, row in self._rows.items()]
        held = [(name, row) for name, row in held if row.any()]
        held.sort(key=lambda entry: -float(entry[1].mean()))
        bands, under = [], np.zeros(self._count, np.float32)
        for name, row in held[:most]:
            bands.append((name, under, under + row))
            under = under + row
        if len(held) > most:
            rest = np.sum([row for _, row in held[most:]], axis=0, dtype=np.float32)
            bands.append(("others", under, under + rest))
        return bands

    def means(self) -> dict[str, float]:
        """Mean ms of each pass over the frames held."""
        return {name: float(self._ordered(row).mean()) for name, row in self._rows.items()} if self._count else {}

    def _ordered(self, row: NDArray[np.float32]) -> NDArray[np.float32]:
        return np.roll(row, -self._next)[self.frames - self._count :]
