"""What a frame of temporal anti-aliasing does: where it samples, what it may take over from the frame before.

docs/antialiasing.md explains the modes. Everything that is large is subtracted here in f64: the shader gets the motion
of the camera between two frames, never a place.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from ...engine.frame import Frame, SunState
from ...engine.space import CameraState, length, projection_terms
from .jitter import jitter_pattern

__all__ = ["Mode", "Motion", "Step", "TemporalState", "camera_motion"]

Floats = NDArray[np.float64]

_TELEPORT_HEIGHTS = 0.25
_TELEPORT_M = 100.0
"""A camera that moves by more than this share of its height and this far within a frame has not flown there. Faster
flight close to the ground is left to the test of each pixel."""
_CUT_COSINE = 0.5
"""Turned by 60 degrees: hardly anything of the last picture is left."""
_SUN_JUMP_COSINE = float(np.cos(np.radians(2.0)))
_LIGHT_JUMP = 0.1


class Mode(IntEnum):
    """Programs of the pass composite.resolve."""

    EDGE = 0
    """This frame alone, steps along outlines smoothed."""
    MEAN = 1
    """Mean with the last frame, pixel by pixel: for a still camera."""
    MOVING = 2
    """Reprojected last frame, tested and clipped."""


@dataclass(frozen=True)
class Step:
    """mode; jitter_px, checkerboard: see Frame; weight: share of this frame in the mean of Mode.MEAN (0: keep)."""

    mode: Mode
    jitter_px: tuple[float, float] = (0.0, 0.0)
    weight: float = 1.0
    checkerboard: int | None = None


@dataclass(frozen=True)
class Motion:
    """From camera coordinates (x right, y up, z forward) of a frame to those of the frame before, and its projection.

    turn: (3, 3) for what belongs to the planet; shift_m: (3,) this camera from the one before, in its axes.
    sky_turn: (3, 3) for what is infinitely far, which turns with the stars. before: (1 / sx, 1 / sy, ox, oy) of
    projection_terms.
    """

    turn: Floats
    shift_m: Floats
    sky_turn: Floats
    before: tuple[float, float, float, float]


@dataclass(eq=False)
class _Moment:
    camera: CameraState
    sun: SunState
    planet: int
    size: tuple[int, int]
    time_s: float = 0.0
    star_axes: Floats | None = None


def camera_motion(
    now: CameraState, then: CameraState, stars_now: Floats | None = None, stars_then: Floats | None = None
) -> Motion:
    """Motion between two cameras of one planet; stars_*: (3, 3) star axes of both frames (None: they stood still).

    A point at p from this camera, in its coordinates, was at turn @ p + shift_m from the camera before.
    """
    turn = then.axes @ now.axes.T
    sky = turn
    if stars_now is not None and stars_then is not None:
        sky = then.axes @ stars_then @ stars_now.T @ now.axes.T
    sx, sy, ox, oy = projection_terms(then)
    return Motion(turn, then.axes @ (now.position_m - then.position_m), sky, (1.0 / sx, 1.0 / sy, ox, oy))


class TemporalState:
    """The state of one view: `begin` before a frame, `motion` in its update, `drawn` when its pass has run."""

    def __init__(self) -> None:
        self._last: _Moment | None = None
        self._now: _Moment | None = None
        self._gathered = 0  # samples of the still picture so far
        self._seeded = False  # it began with a picture of frames that moved
        self._samples = 1
        self._turn = 0  # of the jitter while something moves
        self._flown = 0  # frames since then, modulo 64
        self._then: _Moment | None = None
        self.step = Step(Mode.EDGE)
        self.complete = False
        """Every sample of a still picture is in it, and the last frame showed it as it is."""

    @property
    def share(self) -> float:
        """How much of a still picture is done, 0..1."""
        return min(self._gathered / self._wanted, 1.0)

    @property
    def _wanted(self) -> int:
        return 2 * self._samples if self._seeded else self._samples

    def begin(self, frame: Frame, samples: int, radius_m: float) -> Step:
        """Choose this frame's step. samples: of a still picture. radius_m: of the camera's planet."""
        last, self._last = self._last, None  # comes back with drawn()
        if samples != self._samples:
            self._samples, last = samples, None
        self._now = now = _Moment(frame.camera, frame.sun, frame.planet, frame.size, frame.time_s)
        self._then = last
        usable = last is not None and not frame.cut and not _broken(last, now, radius_m)
        still = usable and frame.still
        if not still:
            self._gathered = 0
        whole = still and self._gathered >= self._wanted
        exact = frame.exact and not frame.settling
        pattern = jitter_pattern(samples)
        if whole or (still and exact and not frame.one_shot):
            self.step = Step(Mode.MEAN, weight=0.0)
        elif frame.one_shot:
            self._gathered = 0
            self.step = Step(Mode.EDGE)
        elif still:
            if not self._gathered:
                self._seeded = not frame.settling
            x, y = pattern[self._gathered % samples]
            self._gathered += 1
            # A seed is worth no sample: it goes with the square of the count, while samples weigh more one after
            # another. Twice around the pattern leaves 20 / (2 n + 5)^2 of it.
            share = 2.0 / (self._gathered + 5.0) if self._seeded else 1.0 / self._gathered
            self.step = Step(Mode.MEAN, (float(x), float(y)), share)
        elif usable and not frame.settling:
            self._turn = (self._turn + 1) % samples
            x, y = (0.0, 0.0) if exact else pattern[self._turn]
            # Thue and Morse's sequence: in step with no speed, at which the same places would never be shaded.
            self._flown = (self._flown + 1) % 64
            checkerboard = None if exact else self._flown.bit_count() & 1
            self.step = Step(Mode.MOVING, (float(x), float(y)), checkerboard=checkerboard)
        else:
            self._turn = self._flown = 0
            self.step = Step(Mode.MEAN if frame.settling else Mode.EDGE)
        self.complete = False
        return self.step

    def motion(self, star_axes: Floats | None) -> Motion | None:
        """From this frame to the last one that was drawn. star_axes: (3, 3) of this frame, or None."""
        if self._now is None:
            return None
        self._now.star_axes = None if star_axes is None else np.array(star_axes, np.float64)
        then = self._then
        if then is None:
            return None
        return camera_motion(self._now.camera, then.camera, self._now.star_axes, then.star_axes)

    @property
    def elapsed_s(self) -> float:
        """Scene time from the last frame that was drawn to this one, either way."""
        return 0.0 if self._now is None or self._then is None else abs(self._now.time_s - self._then.time_s)

    def lost(self) -> None:
        """The picture before is gone after all (the graph was made anew): this frame stands for itself."""
        self._gathered, self._turn = 0, 0
        self.step = Step(Mode.EDGE, self.step.jitter_px)

    def drawn(self) -> None:
        """The pass of this frame has run."""
        self._last = self._now
        self.complete = self.step.mode == Mode.MEAN and self.step.weight == 0.0 and self._gathered >= self._wanted


def _broken(then: _Moment, now: _Moment, radius_m: float) -> bool:
    """Whether nothing of the frame before is worth a look: another planet or size, a teleport, a cut, a jump
    of the sun."""
    a, b = then.camera, now.camera
    height_m = abs(b.distance_m - radius_m)
    moved_m = 0.0 if a is b else length(b.position_m - a.position_m)
    return (
        then.planet != now.planet
        or then.size != now.size
        or moved_m > max(_TELEPORT_HEIGHTS * height_m, _TELEPORT_M)
        or float(a.forward @ b.forward) < _CUT_COSINE
        or (then.sun is not now.sun and _jumped(then.sun, now.sun))
    )


def _jumped(then: SunState, now: SunState) -> bool:
    """Whether the sun stands elsewhere, or shines otherwise, than it could have come to in a frame."""
    irradiance = np.abs(now.irradiance - then.irradiance)
    return float(then.direction @ now.direction) < _SUN_JUMP_COSINE or bool(
        (irradiance > _LIGHT_JUMP * np.maximum(then.irradiance, now.irradiance)).any()
    )
