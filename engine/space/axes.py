"""Directions and local axes on a planet: +Z is its north pole, +X latitude 0 longitude 0, +Y longitude 90 east."""

import logging

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import SpaceError, finite_number, unit_vector
from .vectors import cross, length

_LOG = logging.getLogger(__name__)
Floats = NDArray[np.float64]

_POLE = 1e-12
"""Nearer to the axis than this (6 um on Earth) a direction counts as a pole: east has no meaning there."""
_PARALLEL = 1e-8
"""Sine below which two directions count as parallel: the axes would keep fewer than eight digits."""


def _cos_sin_deg(angle_deg: ArrayLike) -> tuple[Floats, Floats]:
    """cos and sin of degrees, exact at multiples of 90, so that the poles and the axes are hit exactly."""
    angle = np.asarray(angle_deg, dtype=np.float64)
    quarter = np.rint(angle / 90.0)
    rest = np.radians(angle - quarter * 90.0)
    cos, sin = np.cos(rest), np.sin(rest)
    turn = np.where(np.isfinite(quarter), quarter, 0).astype(np.int64) % 4
    return (
        np.choose(turn, [cos, -sin, -cos, sin]) + 0.0,
        np.choose(turn, [sin, cos, -sin, -cos]) + 0.0,
    )


def direction(latitude_deg: ArrayLike, longitude_deg: ArrayLike) -> Floats:
    """Unit directions (..., 3) in planet axes of latitudes and longitudes in degrees. Poles and axes are exact."""
    latitude, longitude = np.broadcast_arrays(
        np.asarray(latitude_deg, dtype=np.float64), np.asarray(longitude_deg, dtype=np.float64)
    )
    if not (np.all(np.isfinite(latitude)) and np.all(np.isfinite(longitude))):
        raise SpaceError(f"direction: expected finite degrees, found {latitude_deg!r}, {longitude_deg!r}")
    if np.any(np.abs(latitude) > 90.0):
        raise SpaceError(f"direction: latitude_deg must be between -90 and 90, found {latitude_deg!r}")
    cos_lat, sin_lat = _cos_sin_deg(latitude)
    cos_lon, sin_lon = _cos_sin_deg(longitude)
    return np.stack([cos_lat * cos_lon, cos_lat * sin_lon, sin_lat], axis=-1)


def latitude_longitude(directions: ArrayLike) -> tuple[Floats, Floats]:
    """Latitudes and longitudes in degrees of directions (..., 3), which need not be unit; longitude 0 at the poles."""
    vector = np.asarray(directions, dtype=np.float64)
    x, y, z = vector[..., 0], vector[..., 1], vector[..., 2]
    return np.degrees(np.arctan2(z, np.hypot(x, y))), np.degrees(np.arctan2(y, x))


def local_axes(up_direction: ArrayLike) -> tuple[Floats, Floats]:
    """The axes along which headings are counted at a place: (heading 0, heading 90), unit vectors (3,).

    Away from the poles they are north and east. At a pole a heading is the longitude looked along, so they are +X, +Y.
    """
    up = unit_vector("up_direction", up_direction)
    across = float(np.hypot(up[0], up[1]))
    if across < _POLE:
        return np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    east = np.array([-up[1] / across, up[0] / across, 0.0])
    north = np.array([-up[2] * up[0] / across, -up[2] * up[1] / across, across])
    return north, east


def heading_pitch_axes(up_direction: ArrayLike, heading_deg: float, pitch_deg: float) -> tuple[Floats, Floats]:
    """Forward and up vectors of a level camera at a place (a direction from the planet's centre).

    heading_deg: 0 north, 90 east; at a pole the longitude looked along. pitch_deg: above the horizon > 0, -90..90.
    """
    up = unit_vector("up_direction", up_direction)
    finite_number("heading_deg", heading_deg)
    finite_number("pitch_deg", pitch_deg, -90.0000001, 90.0000001)
    zero, ninety = local_axes(up)
    cos_heading, sin_heading = _cos_sin_deg(heading_deg)
    cos_pitch, sin_pitch = _cos_sin_deg(pitch_deg)
    level = zero * cos_heading + ninety * sin_heading
    return level * cos_pitch + up * sin_pitch, up * cos_pitch - level * sin_pitch


def orthonormal_axes(forward: ArrayLike, up: ArrayLike | None, vertical: ArrayLike) -> tuple[Floats, Floats, Floats]:
    """Right, up and forward, orthonormal, from a forward direction and a wanted up.

    Where `up` is None or parallel to forward, the first of these that is not parallel is taken: `vertical` (the local
    one), north +Z, then the planet axis least aligned with forward. The choice depends on the arguments only.
    """
    ahead = unit_vector("forward", forward)
    # The last one always works: the smallest component of a unit vector is at most 0.58.
    sizes = [abs(v) for v in ahead.tolist()]
    least = [0.0, 0.0, 0.0]
    least[sizes.index(min(sizes))] = 1.0
    wanted = [] if up is None else [unit_vector("up", up)]
    for number, candidate in enumerate([*wanted, vertical, (0.0, 0.0, 1.0), least]):
        vector = np.asarray(candidate, dtype=np.float64)
        norm = length(vector)
        if norm == 0.0:
            continue
        right = cross(ahead, vector / norm)
        sine = length(right)
        if sine > _PARALLEL:
            if wanted and number > 0:
                _LOG.debug("camera: up %s is parallel to forward %s; took %s as up", up, forward, vector)
            right /= sine
            # Where up and forward are nearly parallel their cross product is nearly zero and leans towards forward.
            right -= ahead * float(right @ ahead)
            right /= length(right)
            above = cross(right, ahead)
            return right, above / length(above), ahead
    raise AssertionError("an axis least aligned with forward cannot be parallel to it")
