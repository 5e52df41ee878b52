"""Small f64 rotations for one body: arcs on the unit sphere and turning vectors about an axis.

No asin or acos: angles come from atan2 of chords, which stays accurate for the 1e-9 rad steps of a slow walk on a large
planet, and for nearly opposite directions.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


def unit(vector: Vector) -> Vector:
    """The vector at length one. A zero or non-finite vector raises ValueError: it has no direction."""
    length = math.sqrt(float(vector @ vector))
    if not (math.isfinite(length) and length > 0.0):
        raise ValueError(f"a direction needs a finite length above zero, found {vector!r}")
    return vector / length


def cross(a: Vector, b: Vector) -> Vector:
    """The cross product of two vectors; numpy's own takes ten times as long for a single pair."""
    ax, ay, az = a.tolist()
    bx, by, bz = b.tolist()
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def arc_angle(a: Vector, b: Vector) -> float:
    """Angle in rad between two unit vectors, from the chord and its complement; accurate at 0 and at pi."""
    chord, complement = a - b, a + b
    return 2.0 * math.atan2(math.sqrt(float(chord @ chord)), math.sqrt(float(complement @ complement)))


def slerp(a: Vector, b: Vector, t: float) -> Vector:
    """The point at the share ``t`` of the great arc from ``a`` to ``b`` (unit vectors); ``t`` may leave 0..1."""
    angle = arc_angle(a, b)
    if angle == 0.0:
        return a
    return unit((math.sin((1.0 - t) * angle) * a + math.sin(t * angle) * b) / math.sin(angle))


def log_map(base: Vector, target: Vector) -> Vector:
    """The tangent at ``base`` that points along the arc to ``target``, as long as the arc (rad)."""
    angle = arc_angle(base, target)
    tangent = target - base * float(base @ target)
    length = math.sqrt(float(tangent @ tangent))
    return tangent * (angle / length) if length > 0.0 else np.zeros(3)


def exp_map(base: Vector, tangent: Vector) -> Vector:
    """Where one lands after walking ``tangent`` (rad, perpendicular to ``base``) along a great circle."""
    angle = math.sqrt(float(tangent @ tangent))
    if angle == 0.0:
        return base
    return unit(base * math.cos(angle) + tangent * (math.sin(angle) / angle))


def turn(vector: Vector, axis: Vector, angle_rad: float) -> Vector:
    """Turn a vector about a unit axis by the right-hand rule (Rodrigues; 1 - cos as 2 sin^2 for small angles)."""
    half = math.sin(0.5 * angle_rad)
    side = cross(axis, vector)
    return vector + math.sin(angle_rad) * side + 2.0 * half * half * cross(axis, side)


def carry(vector: Vector, start: Vector, end: Vector, share: float = 1.0) -> Vector:
    """Turn ``vector`` by ``share`` of the smallest rotation that takes unit ``start`` to unit ``end``."""
    axis = cross(start, end)
    length = math.sqrt(float(axis @ axis))
    if length < 1e-300:
        return vector
    return turn(vector, axis / length, share * arc_angle(start, end))


def any_perpendicular(direction: Vector) -> Vector:
    """A unit vector perpendicular to ``direction``, from the axis least aligned with it."""
    axis = np.zeros(3)
    axis[int(np.argmin(np.abs(direction)))] = 1.0
    return unit(cross(direction, axis))
