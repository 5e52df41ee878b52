"""Which levels a view's clipmap has, where their windows lie, and which texels are new. No GL, float64."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...engine.space import length
from .block import MOST_LEVELS
from .stereographic import Stereographic, nearest_projection

__all__ = ["BLOCK", "Level", "Part", "Reach", "Windows", "reach_of"]

Floats = NDArray[np.float64]
Part = tuple[int, int, int, int]
"""Corner in the window (x, y) and size (x, y), texels."""

BLOCK = 16
"""Windows move by whole multiples of this many texels."""
_SLACK = 12
"""Texels that the camera's foot may be away from a window's middle; more than half a block, so that a camera on a
border does not switch to and fro."""
_FRINGE = 2
_FARTHEST_RAD = 1.75
"""Beyond the horizon of a camera far away: mountains there stand above it."""
_STRAIGHT = 0.05
"""Width of windows, on the map, over which a way towards the sun is straight to two texels in 64."""
_OVERHEAD = 1e-2
"""Square of the sine of the zenith angle of a sun so high that its azimuth differs over a window."""
_SPREAD = 3
"""How far from a new texel the shelter of old ones changes."""


@dataclass
class Level:
    """One level's window. power: texels are 2^-power wide on the map. corner: its first texel, in whole texels."""

    power: int
    corner: tuple[int, int]
    swept: int = -1
    """Number of the sun that its shadows were made for."""
    fresh: list[Part] = field(default_factory=list)
    """Parts without heights."""
    shift: tuple[int, int] = (0, 0)
    """How far it moved since."""


@dataclass(frozen=True)
class Reach:
    """What a view asks for. finest, coarsest: powers."""

    projection: Stereographic
    foot: Floats
    """(2,), place of the camera's foot on the map."""
    finest: int
    coarsest: int


def reach_of(
    direction: Floats,
    altitude_m: float,
    clearance_m: float,
    pixel_rad: float,
    radius_m: float,
    relief_m: tuple[float, float],
    size: int,
    finest_m: float,
    texels_per_pixel: float,
    previous: Stereographic | None,
) -> Reach:
    """Levels for a camera over `direction` (3,), altitude above the reference sphere, clearance above the ground.

    The finest has texels as wide as the nearest pixels ask for, and finest_m at least; the coarsest holds all that can
    be seen and all that casts shadows on it. relief_m: lowest and highest ground.
    """
    projection = nearest_projection(direction, previous)
    foot = projection.place(direction)
    metre = 1.0 / (radius_m * projection.scale(foot))  # on the map
    low, high = relief_m
    ground = radius_m + low
    wanted_m = max(pixel_rad * max(clearance_m, 0.0) / texels_per_pixel, finest_m)
    finest = math.floor(-math.log2(wanted_m * metre))

    def dip(height_m: float) -> float:
        return math.acos(min(ground / max(radius_m + height_m, ground), 1.0))

    angle = min(dip(max(altitude_m, low)) + 2.0 * dip(high), _FARTHEST_RAD)
    away = 2.0 * math.atan(length(foot))  # of the foot from the projection's middle
    edge = min(0.5 * (away + angle), 1.35)
    extent = math.tan(edge) - math.tan(0.5 * away)
    half = 0.5 * size - _SLACK - _FRINGE
    # No texel is finer than that, also where next to nothing is in reach: on a sea that hides all ground.
    most = math.floor(-math.log2(finest_m * metre))
    coarsest = min(math.floor(math.log2(half / extent)), most) if extent > 0.0 else most
    finest = max(finest, coarsest)
    return Reach(projection, foot, finest, max(coarsest, finest - MOST_LEVELS + 1))


class Windows:
    """The windows of one view, coarsest first.

    size: texels a side. layers: layers of the texture arrays; a level of power k lives in layer k modulo that.
    """

    def __init__(self, size: int, layers: int) -> None:
        self.size, self.layers = size, layers
        self.side = 1 << (size - 1).bit_length()
        """Of the textures: texels are stored at their places modulo this."""
        self.projection: Stereographic | None = None
        self.levels: list[Level] = []

    @property
    def half(self) -> float:
        """Half the width, in texels, that a level certainly has around the camera's foot."""
        return 0.5 * self.size - _SLACK - _FRINGE

    def forget(self) -> None:
        """All texels are lost."""
        self.levels = []
        self.projection = None

    def layer(self, level: Level) -> int:
        return level.power % self.layers

    def follow(self, reach: Reach, new_levels: int) -> bool:
        """Move the windows to where the camera is; False if some level is still missing, because no more than
        `new_levels` of them may be filled from nothing (the coarsest always is)."""
        if reach.projection is not self.projection:
            self.projection = reach.projection
            self.levels = []
        kept, foot = {level.power: level for level in self.levels}, reach.foot.tolist()
        coarsest = max(reach.coarsest, reach.finest - self.layers + 1)
        self.levels = []
        complete = True
        for power in range(coarsest, reach.finest + 1):
            level = kept.get(power)
            moved = None if level is None else self._moved(level, foot)
            if moved is None:
                if new_levels <= 0 and self.levels:
                    complete = False
                    break
                new_levels -= 1
                corner = self._corner(power, foot)
                level = Level(power, corner, fresh=[(0, 0, self.size, self.size)])
            else:
                level = moved
            self.levels.append(level)
        return complete

    def _corner(self, power: int, foot: Sequence[float]) -> tuple[int, int]:
        middle = [BLOCK * round(math.ldexp(v, power) / BLOCK) for v in foot]
        return middle[0] - self.size // 2, middle[1] - self.size // 2

    def _moved(self, level: Level, foot: Sequence[float]) -> Level | None:
        """The level at its new place, None if it holds nothing of it."""
        half, power, (x, y) = self.size // 2, level.power, level.corner
        if (
            abs(math.ldexp(foot[0], power) - (x + half)) <= _SLACK
            and abs(math.ldexp(foot[1], power) - (y + half)) <= _SLACK
        ):
            return level
        corner = self._corner(level.power, foot)
        dx, dy = corner[0] - level.corner[0], corner[1] - level.corner[1]
        size = self.size
        if max(abs(dx), abs(dy)) >= size or level.fresh:
            return None
        level.corner, level.shift = corner, (dx, dy)
        rows = (size - abs(dy), 0 if dy >= 0 else abs(dy))  # kept rows: number, first
        if dy:
            level.fresh.append((0, size - dy if dy > 0 else 0, size, abs(dy)))
        if dx:
            level.fresh.append((size - dx if dx > 0 else 0, rows[1], abs(dx), rows[0]))
        return level

    def spread(self, part: Part) -> Part:
        """The texels whose shelter hangs on a part."""
        return self._clipped(part, (-_SPREAD, -_SPREAD), (_SPREAD, _SPREAD))

    def ahead(self, part: Part, steps: float, way: Floats) -> Part:
        """A part with all that up to `steps` steps of `way` (2,) lead to from there."""
        low = [math.floor(min(0.0, steps * v)) - 1 for v in way]
        high = [math.ceil(max(0.0, steps * v)) + 1 for v in way]
        return self._clipped(part, low, high)

    def _clipped(self, part: Part, low: Sequence[int], high: Sequence[int]) -> Part:
        x0, y0 = max(part[0] + low[0], 0), max(part[1] + low[1], 0)
        x1, y1 = min(part[0] + part[2] + high[0], self.size), min(part[1] + part[3] + high[1], self.size)
        return x0, y0, x1 - x0, y1 - y0

    @property
    def whole(self) -> Part:
        return (0, 0, self.size, self.size)

    def unlit(self, level: Level, sun_number: int, way: Floats | None, steps: int) -> list[Part]:
        """Parts of a level that need a sweep: new ones, and those from where the sun's way now leads further through
        the window. way: a step in texels (2,) if it is nearly the same all over the window."""
        if level.swept != sun_number or way is None:
            return [self.whole] if level.swept != sun_number or level.shift != (0, 0) else []
        found: list[Part] = []
        for axis in (0, 1):
            by = level.shift[axis]
            if by == 0:
                continue
            depth = abs(by) + (math.ceil(steps * abs(float(way[axis]))) + 2 if by * way[axis] > 0.0 else 0)
            depth = min(depth, self.size)
            start = self.size - depth if by > 0 else 0
            found.append((start, 0, depth, self.size) if axis == 0 else (0, start, self.size, depth))
        return [self.whole] if sum(w * h for _, _, w, h in found) > 0.8 * self.size**2 else found

    def way_of(self, level: Level, sun: Floats) -> Floats | None:
        """A step towards the sun (3,) at the window's middle in texels, the larger component 1 or -1; None where it
        differs too much over the window."""
        assert self.projection is not None
        half = self.size // 2
        place = np.array([math.ldexp(float(c + half), -level.power) for c in level.corner])
        if math.ldexp(float(self.size), -level.power) > _STRAIGHT:
            return None
        up = self.projection.direction(place) @ self.projection.axes.T
        local = self.projection.axes @ sun
        side = local - up * float(local @ up)
        if float(side @ side) < _OVERHEAD:
            return None
        way = side[:2] - place * side[2]
        return way / np.abs(way).max()
