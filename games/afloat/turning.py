"""Rotations as quaternions (x, y, z, w), and axes at a place on the planet. Everything in float64."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def axes_of(q: Floats) -> Floats:
    """The rotation matrix (3, 3) of a unit quaternion: columns are the body's axes in planet axes."""
    x, y, z, w = q
    return np.array([
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ])  # fmt: skip


def product(a: Floats, b: Floats) -> Floats:
    """First b, then a."""
    x, y, z, w = a
    i, j, k, r = b
    return np.array([
        w * i + x * r + y * k - z * j, w * j - x * k + y * r + z * i, w * k + x * j - y * i + z * r,
        w * r - x * i - y * j - z * k,
    ])  # fmt: skip


def turned(q: Floats, rotation_rad: Floats) -> Floats:
    """q after a rotation about an axis of the body's own, as long as the angle."""
    angle = float(np.linalg.norm(rotation_rad))
    if angle < 1e-12:
        return q
    new = product(q, np.append(rotation_rad / angle * np.sin(0.5 * angle), np.cos(0.5 * angle)))
    return new / np.linalg.norm(new)


def upright(place: Floats, heading_deg: float) -> Floats:
    """Quaternion of a body that stands upright at a place (3,), its +X along a heading (0 north, 90 east)."""
    up = place / np.linalg.norm(place)
    east = np.cross([0.0, 0.0, 1.0], up)
    east /= np.linalg.norm(east)
    heading = np.radians(heading_deg)
    ahead: Floats = np.asarray(np.cos(heading) * np.cross(up, east) + np.sin(heading) * east, dtype=np.float64)
    return quaternion_of(np.stack([ahead, np.cross(up, ahead), up], axis=1))


def quaternion_of(m: Floats) -> Floats:
    """(x, y, z, w) of a rotation matrix (3, 3), as `axes_of` gives it."""
    # Shepperd 1978: from the largest of the four, so that nothing is divided by a small number.
    trace = m[0, 0] + m[1, 1] + m[2, 2]
    squares = np.array([m[0, 0], m[1, 1], m[2, 2], trace]) * 2.0 - trace + 1.0
    squares[3] = trace + 1.0
    k = int(np.argmax(squares))
    skew = np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]])
    if k == 3:
        q = np.append(skew, squares[3])
    else:
        q = np.append(m[k] + m[:, k], skew[k])
        q[k] = squares[k]
    return q / np.linalg.norm(q)
