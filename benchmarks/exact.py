"""The exact geometry that results are held against: extended precision, plain formulas, nothing of the library's.

numpy's long double has 64 bits of mantissa on x86 (1e-19, so 1e-11 m on the largest planets); where it is no wider than
float64 (Windows, some ARM), `EXTENDED` is False and differences below about 1e-8 m mean nothing.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Real = np.longdouble
EXTENDED = bool(np.finfo(Real).eps < 1e-18)

# Local x, local y, outward axis of the faces +X -X +Y -Y +Z -Z.
_FACES = np.array(
    [
        [[0, 0, 1], [0, -1, 0], [1, 0, 0]],
        [[0, 0, -1], [0, -1, 0], [-1, 0, 0]],
        [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
        [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
        [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        [[-1, 0, 0], [0, 1, 0], [0, 0, -1]],
    ]
)


def lattice_direction(face: ArrayLike, i_full: ArrayLike, j_full: ArrayLike) -> NDArray[Any]:
    """Unit directions (..., 3) of lattice points: normalize(tan(pi/4 s) x + tan(pi/4 t) y + z)."""
    quarter = np.arctan(Real(1))
    half = Real(2**29)
    x = np.tan((np.asarray(i_full, dtype=np.int64).astype(Real) - half) / half * quarter)
    y = np.tan((np.asarray(j_full, dtype=np.int64).astype(Real) - half) / half * quarter)
    axes = _FACES[np.asarray(face)].astype(Real)
    v = x[..., None] * axes[..., 0, :] + y[..., None] * axes[..., 1, :] + axes[..., 2, :]
    return v / np.sqrt((v * v).sum(axis=-1))[..., None]


def visible_half_angle(altitude_m: ArrayLike, radius_m: ArrayLike, highest_m: ArrayLike) -> NDArray[Any]:
    """Central angle to the farthest peak in sight: acos(r / (r + a)) + acos(r / (r + peak)).

    As arc sines and cosines of the half angles: acos(r / (r + a)) = 2 asin(sqrt(a / (2 (r + a)))).
    """
    return _arc(altitude_m, radius_m) + _arc(highest_m, radius_m)


def _arc(height_m: ArrayLike, radius_m: ArrayLike) -> NDArray[Any]:
    a, r = np.asarray(height_m, dtype=Real), np.asarray(radius_m, dtype=Real)
    return 2 * np.arcsin(np.sqrt(np.maximum(a, 0) / (2 * (r + np.maximum(a, 0)))))


def ray_sphere(origin: ArrayLike, direction: ArrayLike, radius_m: ArrayLike) -> tuple[NDArray[Any], ...]:
    """(closest approach to the centre, near, far) along rays (..., 3) from the centre's point of view.

    The text-book formula in long double: near and far are the two signed roots, NaN where the line misses.
    """
    o, v = np.asarray(origin, dtype=Real), np.asarray(direction, dtype=Real)
    v = v / np.sqrt((v * v).sum(axis=-1, keepdims=True))
    r = np.asarray(radius_m, dtype=Real)
    along = -(o * v).sum(axis=-1)
    nearest = o + along[..., None] * v
    closest2 = (nearest * nearest).sum(axis=-1)
    half2 = r * r - closest2
    half = np.sqrt(np.where(half2 >= 0, half2, np.nan))
    return np.sqrt(closest2), along - half, along + half


def angle_between(a: ArrayLike, b: ArrayLike) -> NDArray[Any]:
    """Angles in rad between vectors (..., 3), accurate for small ones: 2 atan(|u - v| / |u + v|) of unit vectors."""
    u, v = np.asarray(a, dtype=Real), np.asarray(b, dtype=Real)
    u = u / np.sqrt((u * u).sum(axis=-1, keepdims=True))
    v = v / np.sqrt((v * v).sum(axis=-1, keepdims=True))
    apart, sum_ = u - v, u + v
    return 2 * np.arctan2(np.sqrt((apart * apart).sum(axis=-1)), np.sqrt((sum_ * sum_).sum(axis=-1)))
