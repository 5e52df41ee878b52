"""What a camera is made of: a place or a pose, optics, and the checks of what they are given."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..engine.space import CameraState, direction, heading_pitch_axes, orthonormal_axes
from ..errors import CameraError
from .intrinsics import Intrinsics

if TYPE_CHECKING:
    from ..components import Sun
    from ..scene.scene import PlanetHandle

__all__ = ["Face", "Optics", "Place", "Pose", "SceneCamera", "check_number", "make_place"]

Vector = NDArray[np.float64]

_NARROWEST_DEG, _WIDEST_DEG = 1e-3, 179.0


@dataclass(frozen=True, eq=False)
class Pose:
    """Where a camera is and how it is turned, in planet axes: position_m (3,) f64 from the centre, forward and up (3,)
    f64, unit and at right angles."""

    position_m: Vector
    forward: Vector
    up: Vector

    @classmethod
    def checked(cls, position_m: ArrayLike, forward: ArrayLike, up: ArrayLike) -> Pose:
        """Of any directions; an up along forward gives way to the local vertical, or north where that is no help."""
        position = check_vector("position_m", position_m)
        _, above, ahead = orthonormal_axes(check_unit("forward", forward), check_unit("up", up), position)
        return cls(position, ahead, above)


@dataclass(frozen=True, eq=False)
class Face:
    """A pinhole picture that a lens's picture is made from, with the lens's own eye.

    axes: (3, 3), rows right, up and forward in the camera's right, up and forward. tangents: (left, right, bottom, top)
    of its frustum. size: (width, height) in pixels.
    """

    axes: Vector
    tangents: tuple[float, float, float, float]
    size: tuple[int, int]


@dataclass(frozen=True, eq=False)
class Optics:
    """What a camera takes: its whole vertical angle, or in its place signed angles (left, right, bottom, top) from
    forward, or a lens; and a fixed exposure if it has one. face: the part of a lens's picture that is drawn."""

    fov_y_deg: float = 60.0
    frustum_deg: tuple[float, float, float, float] | None = None
    ev100: float | None = None
    intrinsics: Intrinsics | None = None
    face: Face | None = None

    @classmethod
    def checked(
        cls,
        fov_y_deg: float,
        frustum_deg: Sequence[float] | None = None,
        ev100: float | None = None,
        intrinsics: Intrinsics | None = None,
    ) -> Optics:
        """CameraError for what is out of range."""
        if frustum_deg is not None and intrinsics is not None:
            raise CameraError("Camera: frustum_deg and intrinsics exclude each other: give one of them")
        return cls(
            check_number("fov_y_deg", fov_y_deg, _NARROWEST_DEG, _WIDEST_DEG),
            None if frustum_deg is None else check_frustum(frustum_deg),
            None if ev100 is None else check_ev100(ev100),
            None if intrinsics is None else check_intrinsics(intrinsics),
        )

    @property
    def size(self) -> tuple[int, int] | None:
        """(width, height) of its picture in pixels, where it has one of its own."""
        if self.face is not None:
            return self.face.size
        return None if self.intrinsics is None else self.intrinsics.size

    @property
    def lens(self) -> Intrinsics | None:
        """A lens whose picture has to be resampled from pinhole pictures."""
        resampled = self.face is None and self.intrinsics is not None and not self.intrinsics.is_pinhole
        return self.intrinsics if resampled else None

    def tangents(self, aspect: float) -> tuple[float, float, float, float]:
        """(left, right, bottom, top) of the frustum, for a picture of width / height; of a lens: without its
        distortion."""
        if self.face is not None:
            return self.face.tangents
        if self.intrinsics is not None:
            return self.intrinsics.tangents
        if self.frustum_deg is not None:
            left, right, bottom, top = (float(np.tan(np.radians(angle))) for angle in self.frustum_deg)
            return left, right, bottom, top
        top = float(np.tan(math.radians(self.fov_y_deg) / 2))
        return -top * aspect, top * aspect, -top, top


@dataclass(frozen=True)
class Place:
    """What Camera.at was asked for; kept because its position needs the planet and perhaps the ground."""

    latitude_deg: float
    longitude_deg: float
    altitude_m: float
    heading_deg: float
    pitch_deg: float
    above: str

    def position_m(self, planet: PlanetHandle) -> Vector:
        """(3,) f64 over a planet as it is now. CameraError below its centre."""
        up = direction(self.latitude_deg, self.longitude_deg)
        base = float(planet.surface_height_m(up[None])[0]) if self.above == "ground" else 0.0
        if planet.radius_m + base + self.altitude_m <= 0.0:
            raise CameraError(
                f"Camera.at: altitude_m: expected more than {-(planet.radius_m + base):.12g} m (the planet's centre), "
                f"found {self.altitude_m:.12g}"
            )
        return up * (planet.radius_m + base + self.altitude_m)

    def axes(self) -> tuple[Vector, Vector]:
        """(forward, up), which are the same over every planet."""
        return heading_pitch_axes(direction(self.latitude_deg, self.longitude_deg), self.heading_deg, self.pitch_deg)

    def pose(self, planet: PlanetHandle) -> Pose:
        """Over a planet as it is now."""
        return Pose(self.position_m(planet), *self.axes())


@dataclass(frozen=True, eq=False)
class SceneCamera:
    """A camera in a scene: whose axes its pose is in, and what else it asks of a picture.

    place: of a camera that was told by one. sun, time_s: those that a view brings. printed_place: of a view that has
    another one on the ground that the printed grid draws.
    """

    planet: PlanetHandle
    pose: Pose
    optics: Optics
    place: Place | None = None
    sun: Sun | None = None
    time_s: float | None = None
    printed_place: Place | None = None

    def state(self, aspect: float) -> CameraState:
        """As engine.space wants it. aspect: width / height of the picture."""
        pose, face = self.pose, self.optics.face
        right, up, forward = orthonormal_axes(pose.forward, pose.up, pose.position_m)
        if face is not None:
            right, up, forward = face.axes @ np.array([right, up, forward])
        return CameraState(pose.position_m, forward, up, right, *self.optics.tangents(aspect))


def make_place(
    latitude_deg: float, longitude_deg: float, altitude_m: float, heading_deg: float, pitch_deg: float, above: str
) -> Place:
    if above not in ("sphere", "ground"):
        raise CameraError(f"Camera: above: expected 'sphere' or 'ground', found {above!r}")
    return Place(
        check_number("latitude_deg", latitude_deg, -90.0, 90.0),
        check_number("longitude_deg", longitude_deg),
        check_number("altitude_m", altitude_m),
        check_number("heading_deg", heading_deg),
        check_number("pitch_deg", pitch_deg, -90.0, 90.0),
        above,
    )


def check_number(name: str, value: Any, low: float = -math.inf, high: float = math.inf) -> float:
    expected = "a number" if math.isinf(low) else f"a number from {low:g} to {high:g}"
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise CameraError(f"Camera: {name}: expected {expected}, found {value!r}") from None
    if not math.isfinite(number) or not low <= number <= high:
        raise CameraError(f"Camera: {name}: expected {expected}, found {number:.12g}")
    return number


def check_vector(name: str, value: Any) -> Vector:
    try:
        vector = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        vector = np.zeros(0)
    if vector.shape != (3,):
        raise CameraError(f"Camera: {name}: expected three numbers (x, y, z), found {shown(value)}")
    if not np.all(np.isfinite(vector)):
        raise CameraError(f"Camera: {name}: expected three finite numbers, found {shown(value)}")
    if not np.any(vector):
        what = "the planet's centre has no up" if name == "position_m" else "it has no direction"
        raise CameraError(f"Camera: {name}: expected a vector other than zero, found {shown(value)}; {what}")
    return vector


def check_unit(name: str, value: Any) -> Vector:
    vector = check_vector(name, value)
    vector = vector / np.max(np.abs(vector))  # keeps the direction of tiny and of huge ones
    return vector / np.linalg.norm(vector)


def check_ev100(value: object) -> float:
    return check_number("ev100", value, -20.0, 30.0)


def check_intrinsics(value: object) -> Intrinsics:
    if not isinstance(value, Intrinsics):
        raise CameraError(
            f"Camera: intrinsics: expected a pf.Intrinsics, found {shown(value)}; pf.Intrinsics.load('camera.yml') "
            "reads one"
        )
    return value


def check_frustum(value: Any) -> tuple[float, float, float, float]:
    try:
        left, right, bottom, top = (float(v) for v in value)
    except (TypeError, ValueError):
        raise CameraError(f"Camera: frustum_deg: expected (left, right, bottom, top), found {value!r}") from None
    for name, angle in (("left", left), ("right", right), ("bottom", bottom), ("top", top)):
        if not abs(angle) <= 89.5:
            raise CameraError(f"Camera: frustum_deg: {name}: expected an angle from -89.5 to 89.5, found {angle:g}")
    if not (left < right and bottom < top):
        raise CameraError(f"Camera: frustum_deg: expected left < right and bottom < top, found {value!r}")
    return left, right, bottom, top


def shown(value: Any) -> str:
    text = repr(value.tolist() if isinstance(value, np.ndarray) else value)
    return text if len(text) <= 60 else f"{text[:57]}..."
