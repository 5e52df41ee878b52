"""The float64 oracle of culling: what may be left out because it is out of view or behind the planet.

Every test errs to the side of drawing. `horizon_hidden` is the exact condition for a sphere of ground that is certainly
there (everything below the lowest ground); `CellBounds` are boxes that contain a displaced cell for certain.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .coverage import horizon_tangent
from .lattice import FACE_AXES, cell_corners
from .nearest import NearestPoint

Floats = NDArray[np.float64]

GRAZING = 1e-12
"""Relative widening of the limit angle, far above float64's errors and far below anything visible."""


def limit_angle_rad(camera_altitude_m: float, target_altitude_m: ArrayLike, radius_m: float, lowest_m: float) -> Floats:
    """Central angle beyond which a target at an altitude is hidden behind the sphere radius + lowest from a camera.

    It is infinite for a camera inside that sphere: then nothing is known to hide anything. A target inside it is
    treated as lying on it.
    """
    inner = radius_m + lowest_m
    above = camera_altitude_m - lowest_m
    target = np.maximum(np.asarray(target_altitude_m, dtype=np.float64) - lowest_m, 0.0)
    if above < 0.0:
        return np.full(target.shape, np.inf)
    ratio = target / inner
    return np.arctan(horizon_tangent(above, inner)) + np.arctan(np.sqrt(ratio) * np.sqrt(2.0 + ratio))


def horizon_hidden(
    camera_altitude_m: float, target_altitude_m: ArrayLike, angle_rad: ArrayLike, radius_m: float, lowest_m: float = 0.0
) -> NDArray[np.bool_]:
    """Whether the straight line from a camera to targets at central angles is blocked by the sphere radius + lowest."""
    limit = limit_angle_rad(camera_altitude_m, target_altitude_m, radius_m, lowest_m)
    return np.asarray(angle_rad, dtype=np.float64) > limit * (1.0 + GRAZING)


class CellBounds(NamedTuple):
    """Boxes in planet axes, metres, relative to an origin; both (N, 3)."""

    low_m: Floats
    high_m: Floats


def cell_bounds(
    face: ArrayLike,
    level: ArrayLike,
    i: ArrayLike,
    j: ArrayLike,
    low_m: ArrayLike,
    high_m: ArrayLike,
    radius_m: float,
    origin_m: ArrayLike = (0.0, 0.0, 0.0),
) -> CellBounds:
    """Boxes around cells whose ground lies between heights low_m and high_m, relative to origin_m."""
    return corner_bounds(cell_corners(face, level, i, j), low_m, high_m, radius_m, origin_m)


def corner_bounds(
    corners: Floats, low_m: ArrayLike, high_m: ArrayLike, radius_m: float, origin_m: ArrayLike = (0.0, 0.0, 0.0)
) -> CellBounds:
    """The same from the corners' directions, (N, K, 3): spherical polygons with great circles for edges.

    Each direction of the polygon is a convex combination of its corners, divided by its length, which is at least the
    cosine of the largest angle between the middle and a corner. So the corners at the lowest height, and at the highest
    divided by that cosine, span all of it.
    """
    middle = corners.mean(axis=1)
    middle /= np.linalg.norm(middle, axis=1, keepdims=True)
    cosine = (corners * middle[:, None, :]).sum(axis=2).min(axis=1) * (1.0 - 1e-15)
    count = len(corners)
    low = np.broadcast_to(np.asarray(low_m, dtype=np.float64), count) + radius_m
    high = np.broadcast_to(np.asarray(high_m, dtype=np.float64), count) + radius_m
    origin = np.asarray(origin_m, dtype=np.float64)
    inner = corners * low[:, None, None] - origin
    outer = corners * (high / cosine)[:, None, None] - origin
    both = np.concatenate([inner, outer], axis=1)
    return CellBounds(both.min(axis=1), both.max(axis=1))


def frustum_hidden(bounds: CellBounds, planes: Floats, near_forward: Floats | None = None) -> NDArray[np.bool_]:
    """Which boxes (camera-relative) lie wholly outside one of the planes (P, 3) through the camera.

    With `near_forward` (the camera's forward vector) boxes wholly behind the camera are out as well.
    """
    if near_forward is not None:
        planes = np.concatenate([planes, near_forward[None, :]])
    farthest = np.where(planes[None] > 0.0, bounds.high_m[:, None, :], bounds.low_m[:, None, :])
    scale = np.maximum(np.abs(bounds.low_m), np.abs(bounds.high_m)).max(axis=1)
    return ((farthest * planes[None]).sum(axis=2) < -1e-12 * scale[:, None]).any(axis=1)


def cells_hidden_by_horizon(
    camera_m: ArrayLike,
    face: ArrayLike,
    level: ArrayLike,
    i: ArrayLike,
    j: ArrayLike,
    high_m: ArrayLike,
    radius_m: float,
    lowest_m: float,
) -> NDArray[np.bool_]:
    """Which cells with ground up to high_m are behind the sphere radius + lowest, seen from camera_m."""
    camera = np.asarray(camera_m, dtype=np.float64)
    distance = float(np.linalg.norm(camera))
    faces, levels, i, j = np.broadcast_arrays(*(np.asarray(a, dtype=np.int64) for a in (face, level, i, j)))
    scale = (np.pi / 2) * np.exp2(-levels.astype(np.float64))
    low = np.stack([i, j]) * scale - np.pi / 4
    nearest = NearestPoint(camera / distance, FACE_AXES)
    chord = np.sqrt(nearest.chord_squared(faces, np.tan(low), np.tan(low + scale)))
    # Near the antipode a chord says little about its angle: there the angle is good to 1e-7 only.
    angle = 2.0 * np.arcsin(np.minimum(chord / 2.0, 1.0)) - np.where(chord > 1.99, 1e-7, 0.0)
    return horizon_hidden(distance - radius_m, high_m, angle * (1.0 - GRAZING), radius_m, lowest_m)
