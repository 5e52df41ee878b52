"""What probes are asked: rows of vectors and distances, checked and broadcast."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["FARTHEST_M", "question_distances", "question_number", "question_rows"]

Floats = NDArray[np.float64]
FARTHEST_M = 1.0e18
"""A hundred light years. Its square is a float32, which the shaders form."""
_LEAST = 1.0e-300
"""Vectors that are shorter count as zero: there is no dividing by them."""


def question_rows(_free: tuple[str, ...] = (), **named: ArrayLike) -> list[Floats]:
    """Broadcast to (N, 3) f64. positions_m and those in _free keep their length, the others become unit."""
    found = []
    for name, value in named.items():
        array = np.atleast_2d(_numbers(name, value))
        if array.ndim != 2 or array.shape[1] != 3:
            raise ValueError(f"{name}: expected an array (N, 3) or (3,), found shape {np.shape(value)}")
        bad = ~np.isfinite(array).all(1)
        if bad.any():
            raise ValueError(f"{name}[{int(np.argmax(bad))}]: expected finite numbers, found {array[np.argmax(bad)]}")
        largest = np.abs(array).max(1)
        place = name == "positions_m" or name in _free
        if place and (largest > FARTHEST_M).any():
            row = int(np.argmax(largest))
            raise ValueError(f"{name}[{row}]: expected at most {FARTHEST_M:g} m, found {largest[row]:g}")
        if name not in _free and (largest < _LEAST).any():
            raise ValueError(f"{name}[{int(np.argmin(largest))}]: expected a vector other than zero, found zero")
        if not place:
            # The largest part first: squares may be beyond float64.
            array = array / largest[:, None]
            array = array / np.linalg.norm(array, axis=1, keepdims=True)
        found.append(array)
    count = max((len(a) for a in found if len(a) != 1), default=min(len(a) for a in found))
    for name, array in zip(named, found, strict=True):
        if len(array) not in (1, count):
            raise ValueError(f"{name}: expected 1 or {count} rows, found {len(array)}")
    return [np.ascontiguousarray(np.broadcast_to(a, (count, 3))) for a in found]


def _numbers(name: str, value: ArrayLike) -> Floats:
    try:
        return np.asarray(value, np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}: expected real numbers, all rows equally long: {error}") from None


def question_distances(value: ArrayLike, count: int, name: str = "distance_m") -> Floats:
    """(N,) f64 from one number or N of them; ValueError names what is wrong."""
    array = _numbers(name, value)
    if array.ndim > 1 or array.size not in (1, count):
        raise ValueError(f"{name}: expected one number or {count} of them, found shape {array.shape}")
    if not (np.isfinite(array) & (array >= 0.0)).all():
        raise ValueError(f"{name}: expected finite numbers, at least 0; leave it out for the way to space")
    return np.broadcast_to(np.minimum(array, FARTHEST_M), (count,))


def question_number(value: float, name: str, least: float = -math.inf, most: float = math.inf) -> float:
    """One finite number from least to most; ValueError names what is wrong."""
    array = _numbers(name, value)
    if array.ndim or not np.isfinite(array) or not least <= float(array) <= most:
        limits = f" from {least:g} to {most:g}" if math.isfinite(least) else ""
        raise ValueError(f"{name}: expected one finite number{limits}, found {value!r}")
    return float(array)
