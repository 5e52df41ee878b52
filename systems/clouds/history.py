"""What a frame's clouds may take over from the frame before, and which pixels have their rays in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...engine.frame import Frame
from ...engine.gpu import Compute
from ...engine.space import CameraState, projection_terms

__all__ = ["History", "block_order", "radical_inverse", "turn_share"]

Floats = NDArray[np.float64]

NONE, MOVING, STILL = 0, 1, 2
_MOVING_WEIGHT = 0.5
"""Of a new ray against what the last frame showed there: less is smoother and lags more."""
_TELEPORT_HEIGHTS, _TELEPORT_M = 0.25, 100.0
"""A camera that moves by more than this share of its height and this far within a frame has not flown there."""
_CUT_COSINE = 0.5
_SUN_JUMP_COSINE = float(np.cos(np.radians(2.0)))
_WEATHER_JUMP_S = 120.0
_WIDER, _WIDER_IN_NEW_LIGHT = 1.0, 0.2
"""What history may be more, on both sides, than this frame's rays around have seen, of what these span: they lie blocks
apart, and light peaks between them. Held to no more than they see, a deck of cloud has three quarters of its relief."""
_NEW_LIGHT_FRAMES = 4
"""For so long another light is new: what is left of the old one would be seen as dots, pixels without a ray in it."""
_TURNS_AT_PLACE = 4
"""At least: far rays take steps longer than what they meet, and are sampled evenly by rays through the same place."""
_MOST_CHANCE = 0.25
"""Share of a step in which a sample is placed by chance."""
_PLACES = (
    ((0.0, 0.0),),
    ((0.25, -0.25), (-0.25, 0.25)),
    ((0.375, 0.125), (-0.375, -0.125), (-0.125, 0.375), (0.125, -0.375)),
)
"""Of rays in a pixel, from its middle: as many as there are turns for. Four are a rotated grid."""


def block_order(stride: int) -> list[tuple[int, int]]:
    """Pixels (x, y) of a block in the order of their rays: each far from those just before it. Middle first."""
    left = [(x, y) for y in range(stride) for x in range(stride)]
    order = [(stride // 2, stride // 2)]
    left.remove(order[0])
    while left:
        # Farthest from all that were chosen, on the torus that blocks repeat on.
        def nearest(place: tuple[int, int]) -> float:
            away = np.abs(np.array(order) - np.array(place))
            away = np.minimum(away, stride - away)
            return float((away**2).sum(axis=1).min())

        order.append(max(left, key=nearest))
        left.remove(order[-1])
    return order


def radical_inverse(number: int) -> float:
    """Binary digits of a whole number, mirrored at the point (van der Corput 1935): 0, 1/2, 1/4, 3/4, ... The first 2^k
    are evenly spread over 0..1, whatever k is, and consecutive ones lie far apart."""
    found, digit = 0.0, 1.0
    while number:
        digit /= 2.0
        found += (number & 1) * digit
        number >>= 1
    return found


def turn_share(turn: int, turns: int) -> float:
    """Of a period, 0 to 1: where the pattern stands in a turn, of so many that a still picture is the mean of. They are
    evenly spread, in the order of radical_inverse."""
    order = [radical_inverse(k) for k in range(turns)]
    return sum(other < order[turn % turns] for other in order) / turns


@dataclass(frozen=True)
class _Moment:
    camera: CameraState
    sun: Floats
    time_s: float
    stamp: object
    size: tuple[int, int]
    weather: object


class History:
    """One view's.

    mode: NONE, MOVING or STILL. place: of this frame's rays. complete: the rays of the moment that is shown are all
    there. checkerboard: which blocks have a ray in this frame, 0 or 1; -1: all. pattern, weight: of this frame's rays.
    inside: where in their pixels they go, from the middle, in pixels. turns: rays of each pixel of a still picture.
    wider: what history may be more than this frame's rays around have seen, of what these span.
    turn, shift_m, projection: from this camera to the one before. offset: of this camera's projection, without jitter.
    """

    def __init__(self, stride: int, samples: int, radius_m: float, every: int = 1) -> None:
        """every: 2: every second block has a ray while something moves."""
        self._order = block_order(stride)
        self._wanted = max(len(self._order), samples)
        self.turns = self._wanted // len(self._order)
        self._radius_m, self._every = radius_m, every
        self._last: _Moment | None = None
        self._count = 0
        self._index = 0
        self.mode = NONE
        self.place = self._order[0]
        self.skip = False
        self.checkerboard = -1
        self.pattern, self.weight, self.inside = 0.5, 1.0, (0.0, 0.0)
        self.turn: Floats = np.eye(3)
        self.shift_m: Floats = np.zeros(3)
        self.projection = (1.0, 1.0, 0.0, 0.0)
        self.offset = (0.0, 0.0)
        self.wider = _WIDER
        self._light: object = None
        self._lit = 0

    @property
    def complete(self) -> bool:
        return self._count >= self._wanted

    @property
    def held(self) -> bool:
        """Whether this frame shows what was gathered."""
        return self.skip and self.mode == STILL

    @property
    def share(self) -> float:
        return min(self._count / self._wanted, 1.0)

    def lost(self) -> None:
        """There is no content of the last frame after all."""
        self._count, self._index, self.mode = 0, 0, NONE

    def begin(self, frame: Frame, stamp: object, weather: object = None, light: object = None) -> None:
        """Choose what this frame does. stamp: equal while the clouds themselves are; weather: while its maps are;
        light: while it comes through the same maps of the shadow."""
        self._lit = self._lit + 1 if light == self._light else 0
        self._light = light
        self.wider = _WIDER if self._lit >= _NEW_LIGHT_FRAMES else _WIDER_IN_NEW_LIGHT
        now = _Moment(frame.camera, frame.sun.direction, frame.time_s, stamp, frame.size, weather)
        then, self._last = self._last, now
        same = then is not None and _same(now, then)
        # A picture that settles begins anew with what has become of its air and weather: it shows no trace of the way.
        alone = (frame.settling and not same) or (frame.one_shot and not (same and self.complete))
        if frame.cut or then is None or alone or self._jumped(now, then):
            self._count, self._index, self.mode = 0, 0, NONE
        else:
            self.mode = STILL if same else MOVING
            self._count = self._count if same else 0
        # Nothing is left to be seen: the picture of a still camera costs no rays.
        self.skip = self.mode == STILL and self.complete and (frame.still or frame.one_shot)
        # By Thue and Morse: simple turns would show stripes that stand still at some speeds of the camera.
        alternate = self._every == 2 and self.mode == MOVING
        self.checkerboard = self._index.bit_count() & 1 if alternate else -1
        if self.skip:
            return
        self.place = self._order[self._index % len(self._order)]
        turn = self._index // len(self._order)
        # A pattern of its own for every turn over the block; a still picture is the mean of them.
        self.pattern = (0.5 + turn_share(turn, self.turns)) % 1.0
        # And, if there are enough turns, of places in the pixel: of its middle alone outlines would be stairs. Where
        # anti-aliasing moves the frame, that does.
        aside = self.mode == STILL and frame.jitter_px == (0.0, 0.0)
        places = _PLACES[min((self.turns // _TURNS_AT_PLACE or 1).bit_length(), len(_PLACES)) - 1 if aside else 0]
        self.inside = places[turn * len(places) // self.turns % len(places)]
        # A still picture is their mean. Where it goes on after that something moves in it, and has to come in.
        shown = min(self._count, self._wanted) // len(self._order)
        self.weight = 1.0 / (1.0 + shown) if self.mode == STILL else _MOVING_WEIGHT
        self._index += 1
        self._count += self.checkerboard < 0  # what has a ray of its own is the begin of a still picture
        if then is not None and self.mode == MOVING:
            before = then.camera
            self.turn = before.axes @ now.camera.axes.T
            self.shift_m = before.axes @ (now.camera.position_m - before.position_m)
            sx, sy, ox, oy = projection_terms(before)
            self.projection = (1.0 / sx, 1.0 / sy, ox, oy)
            self.offset = projection_terms(now.camera)[2:]

    def give(self, program: Compute) -> None:
        """Which rays a frame follows, as uniforms of clouds/view_ray.glsl."""
        program.set("u_place", self.place)
        # What is left to chance is as wide as turns lie apart: their mean has nothing of the lattice left. Of fewer
        # than four turns it would be noisier than the lattice is.
        program.set("u_pattern", (self.pattern, min(1.0 / self.turns, _MOST_CHANCE)))
        program.set("u_checkerboard", self.checkerboard)
        program.set("u_inside", self.inside)

    def _jumped(self, now: _Moment, then: _Moment) -> bool:
        moved = float(np.linalg.norm(now.camera.position_m - then.camera.position_m))
        height = abs(float(np.linalg.norm(then.camera.position_m)) - self._radius_m)
        return (
            moved > max(_TELEPORT_HEIGHTS * height, _TELEPORT_M)
            or float(now.camera.forward @ then.camera.forward) < _CUT_COSINE
            or float(now.sun @ then.sun) < _SUN_JUMP_COSINE
            or abs(now.time_s - then.time_s) > _WEATHER_JUMP_S
            or now.stamp != then.stamp
            or now.size != then.size
        )


def _same(now: _Moment, then: _Moment) -> bool:
    a, b = now.camera, then.camera
    return (
        all(np.array_equal(getattr(a, n), getattr(b, n)) for n in ("position_m", "forward", "up"))
        and (a.tan_left, a.tan_right, a.tan_bottom, a.tan_top) == (b.tan_left, b.tan_right, b.tan_bottom, b.tan_top)
        and np.array_equal(now.sun, then.sun)
        and (now.time_s, now.stamp, now.size, now.weather) == (then.time_s, then.stamp, then.size, then.weather)
    )
