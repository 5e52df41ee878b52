"""The camera: where it is, how it is turned and what it takes in, in float64 and planet axes."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .axes import orthonormal_axes
from .errors import SpaceError, finite_number, finite_vector
from .vectors import length

Floats = NDArray[np.float64]


class CameraStamp(NamedTuple):
    """What a camera sees: place and axes as bytes, and the tangents of its frustum."""

    position: bytes
    forward: bytes
    up: bytes
    tan_left: float
    tan_right: float
    tan_bottom: float
    tan_top: float


@dataclass(frozen=True, eq=False)
class CameraState:
    """A camera for one frame. Vectors are (3,) float64 and read-only; the tangents are signed.

    A point with camera coordinates (x right, y up, z forward) is in the picture when z > 0 and
    tan_left <= x / z <= tan_right, tan_bottom <= y / z <= tan_top. Off-axis frusta (tiles, stereo) are nothing special.
    """

    position_m: Floats
    """From the planet's centre, planet axes."""
    forward: Floats
    up: Floats
    right: Floats
    tan_left: float
    tan_right: float
    tan_bottom: float
    tan_top: float
    near_m: float = 0.1

    def __post_init__(self) -> None:
        for name in ("position_m", "forward", "up", "right"):
            vector = finite_vector(f"camera {name}", getattr(self, name))
            vector.setflags(write=False)
            object.__setattr__(self, name, vector)
        right, up, forward = self.right, self.up, self.forward
        off = (
            *(abs(float(v.dot(v)) - 1.0) for v in (right, up, forward)),
            *(abs(float(a.dot(b))) for a, b in ((right, up), (right, forward), (up, forward))),
        )
        if max(off) > 1e-6:
            raise SpaceError(
                f"camera axes: expected orthonormal right, up, forward, found {self.axes.tolist()}; "
                "use CameraState.look"
            )
        for name in ("tan_left", "tan_right", "tan_bottom", "tan_top"):
            finite_number(f"camera {name}", getattr(self, name))
        if not (self.tan_left < self.tan_right and self.tan_bottom < self.tan_top):
            raise SpaceError(
                "camera frustum: expected left < right and bottom < top (signed tangents), found "
                f"{self.tan_left}, {self.tan_right}, {self.tan_bottom}, {self.tan_top}"
            )
        finite_number("camera near_m", self.near_m, 0.0)

    @classmethod
    def look(
        cls,
        position_m: ArrayLike,
        forward: ArrayLike,
        up: ArrayLike | None = None,
        fov_y_deg: float = 60.0,
        aspect: float = 16.0 / 9.0,
        near_m: float = 0.1,
    ) -> "CameraState":
        """A symmetric camera. `up` need not be perpendicular to forward; None or a parallel one: the local vertical."""
        finite_number("fov_y_deg", fov_y_deg, 0.0, 180.0)
        finite_number("aspect", aspect, 0.0)
        top = float(np.tan(math.radians(fov_y_deg) / 2))
        return cls._turned(position_m, forward, up, (-top * aspect, top * aspect, -top, top), near_m)

    @classmethod
    def frustum_deg(
        cls,
        position_m: ArrayLike,
        forward: ArrayLike,
        up: ArrayLike | None,
        frustum_deg: tuple[float, float, float, float],
        near_m: float = 0.1,
    ) -> "CameraState":
        """An off-axis camera from four signed angles (left, right, bottom, top); left and bottom usually negative."""
        if len(frustum_deg) != 4:
            raise SpaceError(f"frustum_deg: expected (left, right, bottom, top), found {frustum_deg!r}")
        angles = [
            finite_number(f"frustum_deg {name}", angle, -90.0, 90.0)
            for name, angle in zip(("left", "right", "bottom", "top"), frustum_deg, strict=True)
        ]
        left, right, bottom, top = (float(np.tan(np.radians(a))) for a in angles)
        return cls._turned(position_m, forward, up, (left, right, bottom, top), near_m)

    @classmethod
    def _turned(
        cls,
        position_m: ArrayLike,
        forward: ArrayLike,
        up: ArrayLike | None,
        tangents: tuple[float, float, float, float],
        near_m: float,
    ) -> "CameraState":
        position = finite_vector("camera position_m", position_m)
        right, above, ahead = orthonormal_axes(forward, up, position)
        return cls(position, ahead, above, right, *tangents, near_m)

    @cached_property
    def distance_m(self) -> float:
        """From the planet's centre."""
        return length(self.position_m)

    @cached_property
    def direction(self) -> Floats:
        """Unit vector from the planet's centre to the camera; +X for a camera at the centre itself."""
        distance = self.distance_m
        found = self.position_m / distance if distance > 0.0 else np.array([1.0, 0.0, 0.0])
        found.setflags(write=False)
        return found

    def altitude_m(self, radius_m: float) -> float:
        """Altitude above the sphere of this radius."""
        return self.distance_m - radius_m

    @cached_property
    def axes(self) -> Floats:
        """(3, 3) with rows right, up, forward: `axes @ v` turns planet axes into camera axes."""
        found = np.array([self.right, self.up, self.forward])
        found.setflags(write=False)
        return found

    @cached_property
    def stamp(self) -> CameraStamp:
        """Equal for cameras that see the same."""
        axes = self.position_m.tobytes(), self.forward.tobytes(), self.up.tobytes()
        return CameraStamp(*axes, self.tan_left, self.tan_right, self.tan_bottom, self.tan_top)

    @cached_property
    def planes(self) -> Floats:
        """See `frustum_planes`; read-only."""
        right, up, forward = self.right, self.up, self.forward
        planes = np.array(
            [
                right - self.tan_left * forward,
                self.tan_right * forward - right,
                up - self.tan_bottom * forward,
                self.tan_top * forward - up,
            ]
        )
        planes /= np.sqrt((planes * planes).sum(axis=1, keepdims=True))
        planes.setflags(write=False)
        return planes

    def pixel_rad(self, height: int) -> float:
        """The angle of one pixel at the middle of the view, for a picture of `height` rows."""
        return (self.tan_top - self.tan_bottom) / height

    def moved(self, position_m: ArrayLike) -> "CameraState":
        """The same camera at another place."""
        return replace(self, position_m=np.asarray(position_m, dtype=np.float64))
