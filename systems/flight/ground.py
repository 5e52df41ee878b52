"""What a camera may not enter: ground and sea of one planet, and ways that stay above them at any speed."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .profile import HeightLike
from .rotation import Vector, unit

Floats = NDArray[np.float64]

_STEEPEST = 4.0
"""Slope for fields that don't tell their own."""
_SLOPE_MARGIN = 1.5
"""Slopes are known at looks, and ground between two looks may be a little steeper than at either."""
_BOTTOMLESS_M = 1e4
_LOOKS = 25
"""From each end of a way to its middle, with steps that grow by the same factor."""
_FEW = 2
"""Positions that are turned into directions one by one."""
_LONGEST = 0.125
"""A way inside the shell that holds all ground is at most so long by the planet's radius."""


class Ground:
    """Heights of a planet's surface above its reference sphere. field None: a smooth sphere; sea_level_m None: dry."""

    def __init__(self, radius_m: float, field: HeightLike | None = None, sea_level_m: float | None = None) -> None:
        if not (math.isfinite(radius_m) and radius_m > 0.0):
            raise ValueError(f"flight: radius_m must be finite and above zero, found {radius_m!r}")
        self.radius_m = float(radius_m)
        self.field: Any = field
        self.sea_level_m = sea_level_m

    @property
    def highest_m(self) -> float:
        """No surface is higher; inf where the field doesn't say."""
        highest = 0.0 if self.field is None else float(getattr(self.field, "highest_m", math.inf))
        return highest if self.sea_level_m is None else max(highest, self.sea_level_m)

    @property
    def steepest(self) -> float:
        """A slope that hardly any ground exceeds."""
        return 0.0 if self.field is None else float(getattr(self.field, "steepest", _STEEPEST))

    def floors(self, positions_m: Floats) -> Floats:
        """Heights (N,) of ground or sea, whichever is higher, below positions (N, 3)."""
        heights = self.dry(positions_m)
        return heights if self.sea_level_m is None else np.maximum(heights, self.sea_level_m)

    def dry(self, positions_m: Floats) -> Floats:
        """Heights (N,) of the ground alone. A sea without ground is bottomless."""
        if self.field is None:
            bottom = 0.0 if self.sea_level_m is None else self.sea_level_m - _BOTTOMLESS_M
            return np.full(len(positions_m), bottom)
        return np.asarray(self.field.height(_directions(positions_m)), dtype=np.float64)

    def floor(self, position_m: Vector) -> float:
        """Height of ground or sea below one position."""
        return float(self.floors(position_m[None])[0])

    def clearance(self, position_m: Vector) -> float:
        """How high one position is above ground or sea; negative below."""
        return _length(position_m) - self.radius_m - self.floor(position_m)

    def lifted(self, position_m: Vector, clearance_m: float) -> Vector:
        """The position itself, or the point right above it that is `clearance_m` above ground and sea."""
        floor = self.floor(position_m) + clearance_m
        if _length(position_m) - self.radius_m >= floor:
            return position_m
        lifted = unit(position_m) * (self.radius_m + floor)
        # The promise is "never below": the rounding of a position is up to 1e-9 m on Earth.
        return lifted if _length(lifted) - self.radius_m >= floor else lifted * (1.0 + 4e-16)

    def is_clear(self, length_m: float, clearance_m: float) -> bool:
        """Whether nothing can stand in a straight way whose ends are that high above the surface."""
        return clearance_m >= 0.5 * self.steepest * length_m + _sag(length_m, self.radius_m)

    def way(self, start_m: Vector, end_m: Vector, clearance_m: float) -> Vector:
        """Where a straight way from `start_m` towards `end_m` may end: at `end_m` if nothing is in between, else turned
        upwards so that it passes over what is, and no longer than it was.

        Surely clear where slopes keep their bounds: ground between two looks is at most half their distance times the
        slope above the line between what was seen (a Lipschitz bound). `start_m` has to be above the surface.
        """
        way = end_m - start_m
        length = _length(way)
        if length == 0.0:
            return end_m
        top = self.radius_m + self.highest_m + clearance_m
        enters = _enters(start_m, way / length, top)
        if enters >= length:
            return end_m
        longest = enters + _LONGEST * self.radius_m
        if length > longest:
            end_m = start_m + way * (longest / length)
        end_m = self.lifted(end_m, clearance_m)
        length = _length(end_m - start_m)
        near = min(self.clearance(start_m), self.clearance(end_m))
        if self.is_clear(length, near):
            return end_m
        return self._over(start_m, end_m, length, clearance_m)

    def _over(self, start_m: Vector, end_m: Vector, length: float, clearance_m: float) -> Vector:
        """`way` where something may be in between."""
        share = _looks(length, max(clearance_m, 1e-3))
        looks = start_m + share[:, None] * (end_m - start_m)
        height = np.sqrt((looks * looks).sum(axis=1)) - self.radius_m
        floor, slope = self._slopes(looks)
        step = np.diff(share) * length
        rise = 0.5 * np.maximum(slope[:-1], slope[1:]) * step + _sag(step, self.radius_m)
        margin = np.zeros(len(share))
        margin[:-1] = rise
        margin[1:] = np.maximum(margin[1:], rise)
        margin[-1] = max(margin[-1], clearance_m)
        missing = float(((floor + margin - height)[1:] / share[1:]).max())
        if missing <= 0.0:
            return end_m
        up = unit(end_m)
        # Verticals at both ends differ by at most an eighth of a radian (_LONGEST): raise by what that loses.
        raised = end_m + up * (missing / max(float(up @ unit(start_m)), 0.5))
        turned = raised - start_m
        longer = _length(turned)
        return raised if longer <= length else self.lifted(start_m + turned * (length / longer), clearance_m)

    def _slopes(self, positions_m: Floats) -> tuple[Floats, Floats]:
        """Floors (N,), and slopes (N,) that they hardly exceed nearby."""
        height_slope = getattr(self.field, "height_slope", None)
        if height_slope is None:
            heights, slopes = self.dry(positions_m), np.full(len(positions_m), self.steepest)
        else:
            heights, slopes = height_slope(_directions(positions_m))
            slopes = np.minimum(slopes * _SLOPE_MARGIN, self.steepest)
        return heights if self.sea_level_m is None else np.maximum(heights, self.sea_level_m), slopes


def _looks(length: float, finest: float) -> Floats:
    """Shares of a way to look at: 0 and 1, and dense near both, where a way is nearest to the ground."""
    first = min(max(0.5 * finest / length, 1e-7), 0.02)
    half = np.geomspace(first, 0.5, _LOOKS)
    return np.concatenate([[0.0], half, 1.0 - half[-2::-1], [1.0]])


def _sag(length: Any, radius_m: float) -> Any:
    """By how much the middle of a straight way is lower than its ends, above a sphere."""
    return length * length / (8.0 * radius_m)


def _enters(start: Vector, direction: Vector, radius: float) -> float:
    """Distance to the sphere around the origin along a ray; 0 inside of it, inf where it is missed."""
    away = float(start @ start) - radius * radius
    if away <= 0.0:
        return 0.0
    along = float(start @ direction)
    under = along * along - away
    if not math.isfinite(radius):
        return 0.0
    return -along - math.sqrt(under) if along < 0.0 and under >= 0.0 else math.inf


def _directions(positions_m: Floats) -> Floats:
    if len(positions_m) > _FEW:
        return positions_m / np.sqrt((positions_m * positions_m).sum(axis=1, keepdims=True))
    # To the bit what a camera there says of itself: fields remember the places that they were asked for last.
    return np.array([position / _length(position) for position in positions_m])


def _length(vector: Vector) -> float:
    return math.sqrt(float(vector @ vector))


__all__ = ["Ground"]
