"""Place: a camera over a latitude and longitude, and the checks of what a camera is given."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..components import Planet
from ..engine.space import direction, heading_pitch_axes
from ..errors import CameraError
from ..scene.scene import PlanetHandle

__all__ = ["Place", "check_frustum", "check_number", "check_unit", "check_vector", "make_place", "shown"]

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class Place:
    """What Camera.at was asked for; kept because its position needs the planet and perhaps the ground."""

    latitude_deg: float
    longitude_deg: float
    altitude_m: float
    heading_deg: float
    pitch_deg: float
    above: str

    def position_m(self, planet: PlanetHandle | None) -> Vector:
        up = direction(self.latitude_deg, self.longitude_deg)
        radius = Planet().radius_m if planet is None else planet.radius_m
        base = 0.0
        if self.above == "ground":
            if planet is None:
                raise CameraError(
                    'camera with above="ground": the height of the ground is that of a scene, and there is none yet; '
                    "load a scene, or give planet=scene.planet"
                )
            base = float(planet.surface_height_m(up[None])[0])
        if radius + base + self.altitude_m <= 0.0:
            raise CameraError(
                f"Camera.at: altitude_m: expected more than {-(radius + base):.12g} m (the planet's centre), "
                f"found {self.altitude_m:.12g}"
            )
        return up * (radius + base + self.altitude_m)

    def axes(self) -> tuple[Vector, Vector]:
        return heading_pitch_axes(direction(self.latitude_deg, self.longitude_deg), self.heading_deg, self.pitch_deg)


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
