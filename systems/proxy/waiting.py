"""When a snap may wait while it is prepared, how long, and where it should lead."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

from ...engine.space import length
from ...engine.surface.coverage import proxy_coverage
from ...engine.surface.proxy import LOWEST_ALTITUDE_M, ProxyCell

__all__ = ["Motion", "may_wait"]

Floats = NDArray[np.float64]

_LAG = 3.0
"""The ground below a camera may be so many times farther away from the proxy: its triangles are then so many times as
long on screen as wanted. In most flights it is less than _PACE; a camera that dives by a fifth of its height in every
frame comes near."""
_PACE = 2.0
"""In the frames from one snap to the next a camera may come so many times nearer to the ground, or as far aside as
makes the ground below it so many times farther from where it was. A snap that was prepared is right for the middle of
its time, so that proxy and camera differ by half of that."""
_BESIDES = 2
"""Frames beyond those that are shared out: to choose cells of the ground, and one to spare."""
_FEW, _FEWEST, _HOPELESS = 6, 4, 3
"""Frames for a snap: so many by choice, so many at the least; with no more left than the last, all is made at once."""
_STEEPEST = 0.25
_USUAL_FRAMES = 8
"""Of these the shortest says how long a frame lasts."""
_MARGIN = 1.05
"""A camera doesn't fly quite as it did in the last frame."""


def may_wait(cell: ProxyCell, position_m: Floats, here_m: float, sea_m: float, ground_m: tuple[float, float]) -> bool:
    """Whether a camera that has left its cell may still be shown with what was made for it: no hole, nothing much
    coarser than wanted.

    here_m: height of the ground or sea below the camera. sea_m: the sea's level, or -inf.
    ground_m: (lowest, highest) ground, above the reference sphere.
    """
    radius = cell.radius_m
    distance = length(position_m)
    altitude = distance - radius
    if (altitude < sea_m) is not (cell.altitude_m < sea_m):
        return False  # under water other cells hide
    above = max(altitude - here_m, LOWEST_ALTITUDE_M)
    foot = position_m / distance
    aside = _angle(foot, cell.direction)
    if _coarser(cell, aside, above) > _LAG:
        return False
    lowest, highest = ground_m
    for drawn_lowest in {lowest, max(lowest, sea_m)}:  # the ground's grid and the sea's
        there = proxy_coverage(cell.covered_altitude_m, cell.covered_sideways_rad, radius, highest, drawn_lowest)
        needed = proxy_coverage(altitude, aside, radius, highest, drawn_lowest)
        if needed.half_angle_rad > there.half_angle_rad:
            return False
    return True


def _angle(a: Floats, b: Floats) -> float:
    return 2.0 * math.atan2(length(a - b), length(a + b))


def _coarser(cell: ProxyCell, aside_rad: float, above_m: float) -> float:
    """How many times longer than wanted triangles below a camera are on screen."""
    return math.hypot(aside_rad * cell.radius_m, cell.altitude_above_ground_m) / above_m


class Motion:
    """How one view's camera moves, from frame to frame."""

    def __init__(self) -> None:
        self._last: tuple[Floats, float] | None = None
        """The foot, and how high the camera is above the ground."""
        self._distance_m: float | None = None
        self._lasts_s: deque[float] = deque(maxlen=_USUAL_FRAMES)
        self._turn = np.zeros(3)
        self._growth = 0.0
        self._steeper = 0.0
        """How much less the growth is than in the frame before; of its size a part (_STEEPEST) at most."""

    def forget(self) -> None:
        """There is no last frame."""
        self._last = self._distance_m = None
        self._turn, self._growth, self._steeper = np.zeros(3), 0.0, 0.0

    def follow(self, position_m: Floats, radius_m: float, ground_m: float, dt_s: float) -> None:
        """Once a frame. ground_m: about the ground's height there."""
        self._lasts_s.append(dt_s)
        # A frame that took long says how fast the camera is, not how long the next ones take.
        usual = min(self._lasts_s) / dt_s if dt_s > 0.0 else 1.0
        distance = length(position_m)
        foot, above = position_m / distance, max(distance - radius_m - ground_m, LOWEST_ALTITUDE_M)
        if self._distance_m is not None and self._last is not None:
            self._turn = usual * (foot - self._last[0])
            # Over the same ground: the proxy's may be another one now.
            before = max(self._distance_m - radius_m - ground_m, LOWEST_ALTITUDE_M)
            growth = usual * math.log(above / before)
            self._steeper = max(min(growth - self._growth, 0.0), -_STEEPEST * abs(growth))
            self._growth = growth
        self._last, self._distance_m = (foot, above), distance

    def frames_of(self, cell: ProxyCell, most: int) -> int:
        """In how many frames the snap that follows a cell should be there: the fewer, the faster the camera moves for
        its height and the farther it is from the cell. 0: at once, there is no time."""
        if self._last is None:
            return most
        foot, above = self._last
        room = max(int(self._room(most)), min(most, _FEW) + _BESIDES)
        frames = next(
            (
                n
                for n in range(1, room + 1)
                if _coarser(cell, _angle(foot + self._way(n) * self._turn, cell.direction), above * self._sinking(n))
                > _LAG
            ),
            room + 1,
        )
        if frames <= _HOPELESS:
            return 0
        # Rather none to spare than very few. Cameras that dive slow down at last: with the fewest, too, it may yet be
        # there in time, and if not, what is missing is made at once.
        return max(frames - 1 - _BESIDES, min(most, max(min(frames, _FEW) - 1, _FEWEST)))

    def _room(self, most: int) -> float:
        """How many frames there may be from one snap to the next."""
        assert self._last is not None and self._distance_m is not None
        sideways = length(self._turn) * self._distance_m / self._last[1]
        pace = max(abs(self._growth) / math.log(_PACE), sideways / math.sqrt(_PACE**2 - 1.0))
        return min(most + _BESIDES, 1.0 / max(pace, 1e-9))

    def foreseen(self, frames: int, most: int) -> tuple[Floats, float]:
        """Where the camera will be in the middle of the time for which the next snap is right: (3,) unit, its foot, and
        how high above the ground. frames: until the snap comes; 0: now."""
        assert self._last is not None and self._distance_m is not None
        foot, above = self._last
        ahead = 1.5 * (frames + _BESIDES) if frames else 0.5 * self._room(most)
        limit = 1.5 * math.log(_PACE)
        grown = above * math.exp(min(max(self._growth * ahead, -limit), limit))
        way = self._way(ahead)
        aside = length(self._turn) * self._distance_m / above
        farthest = 1.5 * math.sqrt(_PACE**2 - 1.0)
        aimed = foot + self._turn * (way if aside * way <= farthest else farthest / aside)
        return aimed / length(aimed), grown

    def _way(self, frames: float) -> float:
        """How many times as far as in the last frame a camera flies in so many: its speed goes with its height."""
        growth = self._growth
        return frames if abs(growth * frames) < 1e-3 else math.expm1(min(growth * frames, 1.0)) / growth

    def _sinking(self, frames: int) -> float:
        """The height above the ground after so many frames, over that of now, where a dive goes on as it gets
        steeper for its height."""
        return math.exp(frames * self._growth + 0.5 * frames * (frames + 1) * self._steeper)

    def covered(self, cell: ProxyCell, frames: int, most: int) -> ProxyCell:
        """A cell that was foreseen, with ground for all of the camera's way until the one after it."""
        assert self._last is not None and self._distance_m is not None
        foot, above = self._last
        cycle = frames + _BESIDES if frames else self._room(most)
        highest, farthest = above, 0.0
        for n in (0, cycle, 2 * cycle):
            highest = max(highest, above * math.exp(min(n * self._growth, 1.0)))
            farthest = max(farthest, _angle(foot + self._way(n) * self._turn, cell.direction))
        # Beyond twice the height above the ground no snap waits.
        farthest = min(farthest, _LAG * highest / cell.radius_m)
        altitude_m = self._distance_m - cell.radius_m
        return cell.covering(altitude_m + _MARGIN * highest - above, _MARGIN * farthest)
