"""The monitors that a window can be on, in the units of window positions. No window library is imported here."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["Monitor", "centred", "monitor_at"]


@dataclass(frozen=True)
class Monitor:
    """x, y: its top left corner; width, height: its size, all in window units. refresh_hz: 0 where nobody knows."""

    name: str
    x: int
    y: int
    width: int
    height: int
    refresh_hz: int = 0

    def __str__(self) -> str:
        rate = f", {self.refresh_hz} Hz" if self.refresh_hz else ""
        return f"{self.name or 'monitor'}, {self.width} x {self.height}{rate}"


def monitor_at(monitors: Sequence[Monitor], position: tuple[int, int], size: tuple[int, int]) -> int:
    """Which monitor shows the most of a window; the first where none shows any of it."""

    def shown(monitor: Monitor) -> int:
        width = min(position[0] + size[0], monitor.x + monitor.width) - max(position[0], monitor.x)
        height = min(position[1] + size[1], monitor.y + monitor.height) - max(position[1], monitor.y)
        return max(width, 0) * max(height, 0)

    return max(range(len(monitors)), key=lambda k: (shown(monitors[k]), -k), default=0)


def centred(monitor: Monitor, size: tuple[int, int]) -> tuple[int, int]:
    """Where a window's corner is to be so that it stands in a monitor's middle; never above or left of the monitor."""
    return (
        monitor.x + max((monitor.width - size[0]) // 2, 0),
        monitor.y + max((monitor.height - size[1]) // 2, 0),
    )
