"""Distances and angles to the horizon of a sphere. Altitudes at or below 0 see no farther than their own foot."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


def horizon_distance_m(altitude_m: ArrayLike, radius_m: ArrayLike) -> Floats:
    """Length of the tangent from an altitude to the sphere: sqrt(a (2 r + a))."""
    altitude = np.maximum(np.asarray(altitude_m, dtype=np.float64), 0.0)
    return np.sqrt(altitude) * np.sqrt(2.0 * np.asarray(radius_m, dtype=np.float64) + altitude)


def horizon_angle_rad(altitude_m: ArrayLike, radius_m: ArrayLike) -> Floats:
    """Central angle from the foot to the horizon, acos(r / (r + a)) without its cancellation."""
    return np.arctan2(horizon_distance_m(altitude_m, radius_m), np.asarray(radius_m, dtype=np.float64))


def horizon_dip_rad(altitude_m: ArrayLike, radius_m: ArrayLike) -> Floats:
    """How far below the level the horizon is seen: the same angle as at the centre."""
    return horizon_angle_rad(altitude_m, radius_m)


def sight_distance_m(altitude_m: ArrayLike, target_altitude_m: ArrayLike, radius_m: ArrayLike) -> Floats:
    """The longest straight line of sight between two altitudes that the sphere lets through."""
    return horizon_distance_m(altitude_m, radius_m) + horizon_distance_m(target_altitude_m, radius_m)
