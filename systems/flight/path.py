"""Scripted paths: a pose for every time, in f64, from key frames or along a great circle.

Altitudes are interpolated in the logarithm (seven decades between space and a beach), directions with a spline of
slerps (de Casteljau on the unit sphere), heading, pitch and field of view with monotone cubics that never overshoot a
key. All of them have a continuous first derivative.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from ...engine.space import CameraState, direction, heading_pitch_axes
from .profile import Array, GroundProfile, HeightLike
from .rotation import Vector, exp_map, log_map, slerp, unit

if TYPE_CHECKING:
    from collections.abc import Sequence


@dataclass(frozen=True, slots=True)
class Pose:
    """Where a camera is and looks: planet-centred metres and unit vectors in planet axes, f64."""

    position_m: Vector
    forward: Vector
    up: Vector
    fov_y_deg: float


@dataclass(frozen=True, slots=True)
class PathSun:
    """Where the sun stands over a place: degrees above the horizon and from north over east."""

    elevation_deg: float
    azimuth_deg: float
    latitude_deg: float
    longitude_deg: float

    def direction(self) -> Vector:
        """Unit vector to the sun in planet axes."""
        up = direction(self.latitude_deg, self.longitude_deg)
        return heading_pitch_axes(up, self.azimuth_deg, self.elevation_deg)[0]


@dataclass(frozen=True, slots=True)
class KeyFrame:
    """One key: at ``time_s`` the camera is ``altitude_m`` above the ground (or the sphere, as the path says)."""

    time_s: float
    latitude_deg: float
    longitude_deg: float
    altitude_m: float
    heading_deg: float = 0.0
    pitch_deg: float = 0.0
    fov_y_deg: float = 60.0


@dataclass(frozen=True, slots=True)
class Path:
    """What every path has. ``over(radius_m, field)`` binds it to a planet; the bound path answers ``camera_at(t)``.
    planet: the preset that its places and heights were chosen for, "" for any."""

    name: str
    help: str = ""
    planet: str = ""
    above: str = "ground"
    smooth_s: float = 4.0
    clearance_m: float = 1.0
    sun: PathSun | None = None

    @property
    def duration_s(self) -> float:
        raise NotImplementedError

    def over(self, radius_m: float, field: HeightLike | None = None, sea_level_m: float | None = None) -> BoundPath:
        """This path over a planet: ``field`` None is a smooth sphere, ``sea_level_m`` None is dry."""
        return BoundPath(self, radius_m, field, sea_level_m)

    def track(self, time_s: float, radius_m: float) -> Vector:
        """Unit direction from the planet's centre."""
        raise NotImplementedError

    def height_above(self, time_s: float) -> float:
        """Metres above the (smoothed) ground or the sphere."""
        raise NotImplementedError

    def look(self, time_s: float, place: Vector, radius_m: float) -> tuple[Vector, Vector, float]:
        """Forward, up and the vertical field of view in degrees at that place."""
        raise NotImplementedError


@dataclass(frozen=True, slots=True)
class KeyFramePath(Path):
    """A spline through key frames in ascending time."""

    keys: tuple[KeyFrame, ...] = ()
    _splines: _Splines = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_splines", _Splines(self.keys))

    @property
    def duration_s(self) -> float:
        return self.keys[-1].time_s

    def track(self, time_s: float, radius_m: float) -> Vector:
        return self._splines.direction(time_s)

    def height_above(self, time_s: float) -> float:
        return math.exp(self._splines.log_altitude(time_s))

    def look(self, time_s: float, place: Vector, radius_m: float) -> tuple[Vector, Vector, float]:
        splines = self._splines
        forward, up = heading_pitch_axes(place, splines.heading_deg(time_s), splines.pitch_deg(time_s))
        return forward, up, splines.fov_y_deg(time_s)


@dataclass(frozen=True, slots=True)
class CruisePath(Path):
    """A great circle at constant ground speed and height, looking along the way."""

    latitude_deg: float = 0.0
    longitude_deg: float = 0.0
    heading_deg: float = 0.0
    speed_m_s: float = 300.0
    altitude_m: float = 100.0
    pitch_deg: float = -4.0
    fov_y_deg: float = 60.0
    lasts_s: float = 60.0

    @property
    def duration_s(self) -> float:
        return self.lasts_s

    def track(self, time_s: float, radius_m: float) -> Vector:
        start, along = self._start()
        return exp_map(start, along * (self.speed_m_s * time_s / radius_m))

    def height_above(self, time_s: float) -> float:
        return self.altitude_m

    def look(self, time_s: float, place: Vector, radius_m: float) -> tuple[Vector, Vector, float]:
        start, along = self._start()
        angle = self.speed_m_s * time_s / radius_m
        level = along * math.cos(angle) - start * math.sin(angle)
        pitch = math.radians(self.pitch_deg)
        up = place * math.cos(pitch) - level * math.sin(pitch)
        return level * math.cos(pitch) + place * math.sin(pitch), up, self.fov_y_deg

    def _start(self) -> tuple[Vector, Vector]:
        start = direction(self.latitude_deg, self.longitude_deg)
        return start, heading_pitch_axes(start, self.heading_deg, 0.0)[0]


class BoundPath:
    """A path over one planet. Deterministic: the same time always gives the same pose, to the bit."""

    def __init__(
        self, path: Path, radius_m: float, field: HeightLike | None = None, sea_level_m: float | None = None
    ) -> None:
        if not (math.isfinite(radius_m) and radius_m > 0.0):
            raise ValueError(f"path {path.name!r}: radius_m must be finite and above zero, found {radius_m!r}")
        self.path, self.radius_m, self.field, self.sea_level_m = path, float(radius_m), field, sea_level_m
        self._profile: GroundProfile | None = None
        if field is not None and path.above == "ground":
            self._profile = GroundProfile(
                self._tracks, path.duration_s, field, sea_level_m=sea_level_m, window_s=path.smooth_s
            )

    @property
    def duration_s(self) -> float:
        return self.path.duration_s

    def pose_at(self, time_s: float) -> Pose:
        """The pose at a time in s, clamped to the path; never below ground or water plus the path's ``clearance_m``."""
        time_s = min(max(float(time_s), 0.0), self.duration_s)
        place = self.path.track(time_s, self.radius_m)
        altitude = self.path.height_above(time_s) + (self._profile.height(time_s) if self._profile else 0.0)
        altitude = max(altitude, self._floor(place) + self.path.clearance_m)
        forward, up, fov = self.path.look(time_s, place, self.radius_m)
        return Pose(place * (self.radius_m + altitude), forward, up, fov)

    def camera_at(self, time_s: float, aspect: float = 16.0 / 9.0) -> CameraState:
        """The pose as the engine's camera."""
        pose = self.pose_at(time_s)
        return CameraState.look(pose.position_m, pose.forward, pose.up, pose.fov_y_deg, aspect)

    def times_s(self, count: int) -> Array:
        """``count`` times from the start to the end, both included."""
        return np.linspace(0.0, self.duration_s, count) if count > 1 else np.array([self.duration_s])

    def _tracks(self, times_s: Array) -> Array:
        return np.stack([self.path.track(float(t), self.radius_m) for t in times_s])

    def _floor(self, place: Vector) -> float:
        ground = 0.0 if self.field is None else float(np.asarray(self.field.height(place[None, :]))[0])
        return ground if self.sea_level_m is None else max(ground, self.sea_level_m)


class MonotoneCubic:
    """Cubic through (x, y) with Fritsch and Carlson's slopes (1980): C1, and monotone wherever the data is."""

    def __init__(self, x: Sequence[float], y: Sequence[float]) -> None:
        self.x, self.y = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
        width = np.diff(self.x)
        secant = np.diff(self.y) / width
        slope = np.zeros(len(self.x))
        if len(self.x) == 2:
            slope[:] = secant[0]
        for i in range(1, len(self.x) - 1):
            left, right = secant[i - 1], secant[i]
            if left * right > 0.0:
                a, b = 2.0 * width[i] + width[i - 1], width[i] + 2.0 * width[i - 1]
                slope[i] = (a + b) / (a / left + b / right)
        self.slope = slope

    def __call__(self, x: float) -> float:
        if len(self.x) == 1:
            return float(self.y[0])
        i = int(np.clip(np.searchsorted(self.x, x, side="right") - 1, 0, len(self.x) - 2))
        width = float(self.x[i + 1] - self.x[i])
        t = min(max((x - float(self.x[i])) / width, 0.0), 1.0)
        y0, y1 = float(self.y[i]), float(self.y[i + 1])
        m0, m1 = float(self.slope[i]) * width, float(self.slope[i + 1]) * width
        return y0 + t * (m0 + t * (3.0 * (y1 - y0) - 2.0 * m0 - m1 + t * (2.0 * (y0 - y1) + m0 + m1)))


class _Splines:
    """The channels of a key-frame path."""

    def __init__(self, keys: Sequence[KeyFrame]) -> None:
        times = [key.time_s for key in keys]
        if len(keys) < 2 or times[0] != 0.0 or any(b <= a for a, b in itertools.pairwise(times)):
            raise ValueError(f"two or more key frames need ascending times from 0 s, found {times}")
        self.times = times
        headings = np.degrees(np.unwrap(np.radians([key.heading_deg for key in keys])))
        self.log_altitude = MonotoneCubic(times, [math.log(key.altitude_m) for key in keys])
        self.heading_deg = MonotoneCubic(times, headings.tolist())
        self.pitch_deg = MonotoneCubic(times, [key.pitch_deg for key in keys])
        self.fov_y_deg = MonotoneCubic(times, [key.fov_y_deg for key in keys])
        self.places = [unit(direction(key.latitude_deg, key.longitude_deg)) for key in keys]
        self.rates = self._tangents()

    def _tangents(self) -> list[Vector]:
        """Velocity (rad/s) at each key. At the ends zero; between, the two arcs weighed by how near in time their far
        ends are, cut to three times the slower one: a camera that stops at the next key must not swing past it."""
        rates = [np.zeros(3) for _ in self.places]
        for i in range(1, len(self.places) - 1):
            before, after = self.times[i] - self.times[i - 1], self.times[i + 1] - self.times[i]
            left = -log_map(self.places[i], self.places[i - 1]) / before
            right = log_map(self.places[i], self.places[i + 1]) / after
            rate = (after * left + before * right) / (before + after)
            limit = 3.0 * min(_length(left), _length(right))
            length = _length(rate)
            rates[i] = rate * (limit / length) if length > limit else rate
        return rates

    def direction(self, time_s: float) -> Vector:
        if len(self.places) == 1:
            return self.places[0]
        i = int(np.clip(np.searchsorted(self.times, time_s, side="right") - 1, 0, len(self.times) - 2))
        width = self.times[i + 1] - self.times[i]
        t = min(max((time_s - self.times[i]) / width, 0.0), 1.0)
        a, d = self.places[i], self.places[i + 1]
        b = exp_map(a, self.rates[i] * (width / 3.0))
        c = exp_map(d, self.rates[i + 1] * (-width / 3.0))
        ab, bc, cd = slerp(a, b, t), slerp(b, c, t), slerp(c, d, t)
        return slerp(slerp(ab, bc, t), slerp(bc, cd, t), t)


def _length(vector: Vector) -> float:
    return math.sqrt(float(vector @ vector))


__all__ = [
    "BoundPath",
    "CruisePath",
    "KeyFrame",
    "KeyFramePath",
    "MonotoneCubic",
    "Path",
    "PathSun",
    "Pose",
]
