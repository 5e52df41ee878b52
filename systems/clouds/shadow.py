"""Maps of the clouds' shadow around a camera: which are due, and where they lie."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

import moderngl
import numpy as np
from numpy.typing import NDArray

from .view_block import MOST_MAPS

__all__ = ["ShadowMaps"]

Floats = NDArray[np.float64]

_WIDER = 4.0
_FIRST = 4.0
"""Half width of the first map, in thicknesses of the first layer."""
_MOVED = 1.0 / 16.0
"""A camera that has moved by this share of a map's half width wants it anew."""
_LAG = 0.5
"""And may have moved by this one until it is drawn: it lies well within it still."""
_DRIFTED_TEXELS = 0.5
_SUN_STEP_RAD = 2e-4
MOST_LONGER = 8.0
"""A map is longer towards the sun than it is wide, as shadows are, but no more than this."""
_LEAST_SIDEWAYS = 1e-3
"""Of the sun's direction: nearer to the zenith it has no azimuth worth following."""
_USUAL_FRAMES = 8
"""So many frames tell at what pace a camera flies."""
_FINE_PIXELS = 0.5
"""A map whose texels are this share of a pixel shows all that there is to be seen."""


@dataclass
class ShadowMap:
    middle: Floats = field(default_factory=lambda: np.zeros(3))
    """Its foot, from the planet's centre."""
    u: Floats = field(default_factory=lambda: np.zeros(3))
    v: Floats = field(default_factory=lambda: np.zeros(3))
    half_m: float = 0.0
    longer: float = 1.0
    """Its half length along u, in half widths."""
    stamp: object = None
    sun: Floats = field(default_factory=lambda: np.zeros(3))
    time_s: float = math.inf
    steady: bool = True
    """Whether the weather that it shows is what its time asked for, and no stand-in."""


@dataclass
class Making:
    """A map that is drawn strip by strip, from where it was begun: it takes its place when it is whole."""

    number: int
    map: ShadowMap
    frames: int
    strips: int = 0
    rows: int = 0
    """So many are drawn."""


class ShadowMaps:
    """Up to MOST_MAPS squares around the camera's foot, each _WIDER times wider than the one before."""

    def __init__(self, texels: int) -> None:
        self.texels = texels
        self.maps: list[ShadowMap] = []
        self.making: Making | None = None
        self.finest = 0
        """Finer ones are not drawn."""
        self.changes = 0
        """How often a map that was made took another's place, which a still camera sees."""
        self.texture: moderngl.Texture | None = None
        """Which they were drawn into."""
        self._steady = True
        self._before: tuple[Floats, Floats, float] | None = None
        self._pace = (0.0, 0.0, 0.0)
        self._steps: deque[float] = deque(maxlen=_USUAL_FRAMES)
        """How far the foot came in the last frames, radians; the least is its pace, which no leap is."""

    def forget(self) -> None:
        """All maps are due."""
        self.maps, self.making = [], None
        self._steps.clear()

    def place(self, radius_m: float, thickness_m: float) -> None:
        """As many maps as it takes to cover the side of the planet that a camera sees."""
        widths = [_FIRST * thickness_m * _WIDER**k for k in range(MOST_MAPS)]
        widths = [w for k, w in enumerate(widths) if k == 0 or widths[k - 1] < radius_m]
        widths = [min(w, 0.98 * radius_m) for w in widths]
        if [m.half_m for m in self.maps] != widths:
            self.maps, self.making = [ShadowMap(half_m=w) for w in widths], None

    def need(self, pixel_m: float) -> None:
        """From so far away that pixels are so wide on the clouds: maps are let go of while the next one is finer
        than pixels are. Nobody would ask them, and at the pace of a flight from space each would be drawn again and
        again."""
        texels_m = [2.0 * held.half_m / self.texels for held in self.maps[1:]]
        self._let_go(sum(texel_m <= _FINE_PIXELS * pixel_m for texel_m in texels_m))

    def outrun(self, frames: Sequence[int], radius_m: float) -> None:
        """Maps that the camera leaves in less time than they are drawn in are let go of, too: whatever was shown of
        them would be behind it. frames: of each map."""
        step_m = min(self._steps) * radius_m if len(self._steps) == _USUAL_FRAMES else 0.0
        outrun = [number for number, held in enumerate(self.maps[:-1]) if held.half_m < step_m * frames[number]]
        self._let_go(max(self.finest, max(outrun, default=-1) + 1))

    def _let_go(self, finest: int) -> None:
        self.finest = finest
        for held in self.maps[: self.finest]:
            held.stamp = None
        if self.making is not None and self.making.number < self.finest:
            self.making = None

    def follow(self, foot: Floats, sun: Floats, time_s: float, steady: bool = True) -> None:
        """Once a frame: how fast camera, sun and time go. steady: the weather is what the time asks for; maps of a
        stand-in are then due, but shown until they are drawn anew, for they differ little."""
        self._steady = steady
        before, self._before = self._before, (foot, sun, time_s)
        if before is not None:
            away, turned = foot - before[0], sun - before[1]
            self._pace = float(np.abs(away).max()), float(np.abs(turned).max()), abs(time_s - before[2])
            self._steps.append(self._pace[0])

    def frames_for(self, number: int, most: int, wind_m_s: float, radius_m: float) -> int:
        """Over how many frames a map may be drawn: no more than it stays right for at this pace."""
        half_m = self.maps[number].half_m
        moved, turned, passed_s = self._pace
        share = max(
            moved * radius_m / (_LAG * half_m),
            turned / _SUN_STEP_RAD,
            passed_s * max(wind_m_s, 1.0) / (_DRIFTED_TEXELS * 2.0 * half_m / self.texels),
        )
        return most if share * most <= 1.0 else max(int(1.0 / share), 1)

    def due(
        self, foot: Floats, sun: Floats, time_s: float, wind_m_s: float, stamp: object, radius_m: float
    ) -> list[int]:
        """Numbers of the maps that no longer show what they should, finest first. foot: unit direction."""
        found = []
        for number, held in enumerate(self.maps):
            if number < self.finest:
                continue
            away = foot * radius_m - held.middle
            moved = max(abs(away @ held.u) / held.longer, abs(away @ held.v)) > _MOVED * held.half_m
            texel_m = 2.0 * held.half_m / self.texels
            drifted = abs(time_s - held.time_s) * max(wind_m_s, 1.0) > _DRIFTED_TEXELS * texel_m
            turned = float(np.abs(sun - held.sun).max()) > _SUN_STEP_RAD
            stood_in = self._steady and not held.steady
            if held.stamp != stamp or moved or drifted or turned or stood_in:
                found.append(number)
        return found

    def move(
        self, number: int, foot: Floats, sun: Floats, time_s: float, stamp: object, radius_m: float, alone: bool = False
    ) -> ShadowMap:
        """The map is about to be drawn around `foot`, all of it. alone: for a picture that hangs on no other."""
        half_m = self.maps[number].half_m
        where = (sun, time_s, stamp, radius_m)
        held = _placed(half_m, foot, *where) if alone else self._placed(number, foot, *where)
        held.steady = self._steady
        self.maps[number] = held
        return held

    def begin(
        self, number: int, frames: int, foot: Floats, sun: Floats, time_s: float, stamp: object, radius_m: float
    ) -> None:
        """From now on the map is drawn in strips, around this foot."""
        held = self._placed(number, foot, sun, time_s, stamp, radius_m)
        held.steady = self._steady
        self.making = Making(number, held, frames)

    def _placed(
        self, number: int, foot: Floats, sun: Floats, time_s: float, stamp: object, radius_m: float
    ) -> ShadowMap:
        before = self.maps[number]
        if before.stamp == stamp and stamp is not None:
            foot = _on_texels(before, foot, radius_m, self.texels)
        return _placed(before.half_m, foot, sun, time_s, stamp, radius_m)

    def finish(self) -> int:
        """The map that was made takes its place; its number."""
        assert self.making is not None
        made, self.making = self.making, None
        self.maps[made.number] = made.map
        self.changes += 1
        return made.number


def _on_texels(before: ShadowMap, foot: Floats, radius_m: float, texels: int) -> Floats:
    """The foot nearest to `foot` from which a map has its texels where the one before had them. From elsewhere the same
    shadows would be sampled a little aside, and all of the ground's light would step when the map takes its place."""
    away = foot * radius_m - before.middle
    texel_m = 2.0 * before.half_m / texels
    along, across = round(float(away @ before.u) / (texel_m * before.longer)), round(float(away @ before.v) / texel_m)
    moved = before.middle + (along * texel_m * before.longer) * before.u + (across * texel_m) * before.v
    found = np.asarray(moved / np.linalg.norm(moved), np.float64)
    # After a leap the old map's plane lies far from the sphere, and there are no texels to keep.
    return found if float(np.linalg.norm(found - foot)) * radius_m < texel_m * before.longer else foot


def _placed(half_m: float, foot: Floats, sun: Floats, time_s: float, stamp: object, radius_m: float) -> ShadowMap:
    """A map around a foot, longer towards the sun."""
    held = ShadowMap(half_m=half_m)
    rise = float(foot @ sun)
    along = sun - rise * foot
    if np.linalg.norm(along) < _LEAST_SIDEWAYS:
        along = np.cross(np.eye(3)[int(np.argmin(np.abs(foot)))], foot).astype(np.float64)
    held.u = along / np.linalg.norm(along)
    held.v = np.cross(foot, held.u)
    # Seen from the sun a map is a square, as far as the planet has room for it.
    held.longer = max(min(1.0 / max(rise, 1.0 / MOST_LONGER), 0.98 * radius_m / held.half_m), 1.0)
    held.middle, held.sun, held.time_s, held.stamp = foot * radius_m, sun.copy(), time_s, stamp
    return held
