"""Cones of directions against a view: the smallest angle from a direction to the picture, exact for its pyramid."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .camera import CameraState

_ROUNDING_RAD = 1e-9
"""Above what rounding does to angles here, far below a pixel."""


def least_angle_rad(camera: CameraState, direction: ArrayLike, margin: float = 0.0) -> float:
    """The angle from a unit direction (planet axes) to the nearest direction of the picture, 0 within it.

    margin: how much wider the picture counts on each side, as a tangent; a pixel for what is drawn with jitter.
    """
    d: NDArray[np.float64] = camera.axes @ np.asarray(direction, dtype=np.float64)
    x, y, z = d.tolist()
    left, right = camera.tan_left - margin, camera.tan_right + margin
    bottom, top = camera.tan_bottom - margin, camera.tan_top + margin
    if z > 0.0 and left * z <= x <= right * z and bottom * z <= y <= top * z:
        return 0.0
    # Outside, the nearest one is on a side: at the foot of the direction on it, or at a corner where that is not on it.
    nearest = [(a, b) for a in (left, right) for b in (bottom, top)]
    for a in (left, right):
        depth = a * x + z
        if depth > 0.0 and bottom * depth <= y * (1.0 + a * a) <= top * depth:
            nearest.append((a, y * (1.0 + a * a) / depth))
    for b in (bottom, top):
        depth = b * y + z
        if depth > 0.0 and left * depth <= x * (1.0 + b * b) <= right * depth:
            nearest.append((x * (1.0 + b * b) / depth, b))
    return min(
        math.atan2(math.hypot(y - z * b, z * a - x, x * b - y * a), x * a + y * b + z) for a, b in nearest
    )  # fmt: skip


def sphere_unseen(camera: CameraState, radius_m: float, margin: float = 0.0) -> bool:
    """Whether no ray of the picture meets the sphere of this radius about the planet's centre: the cone that it fills
    against the view's pyramid. Never so from inside the sphere. margin: as in least_angle_rad."""
    beyond_m = camera.distance_m - radius_m
    if beyond_m <= 0.0:
        return False
    tangent_m = math.sqrt(beyond_m) * math.sqrt(camera.distance_m + radius_m)
    half_rad = math.atan2(radius_m, tangent_m)
    return least_angle_rad(camera, -camera.direction, margin) > half_rad + _ROUNDING_RAD


def least_elevation_rad(camera: CameraState, margin: float = 0.0) -> float:
    """How far above the level the lowest direction of the picture is. margin: as in least_angle_rad."""
    return least_angle_rad(camera, -camera.direction, margin) - 0.5 * math.pi
