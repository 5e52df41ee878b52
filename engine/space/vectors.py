"""Single vectors (3,) in float64, as a frame has a hundred of them: numpy's functions for arrays of any shape take ten
times as long for one, and give the same bits."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["cross", "length", "split_pair"]

Floats = NDArray[np.float64]


def length(vector: Floats) -> float:
    """The length of a vector, any number of components; what np.linalg.norm says."""
    return math.sqrt(vector.dot(vector))


def cross(a: Floats, b: Floats) -> Floats:
    """The cross product of two vectors (3,); what np.cross says."""
    ax, ay, az = a.tolist()
    bx, by, bz = b.tolist()
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def split_pair(values: ArrayLike) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Two float32 whose sum is each value to 48 bits, as common/pair.glsl has them: high, low."""
    exact = np.asarray(values, dtype=np.float64)
    high = exact.astype(np.float32)
    return high, (exact - high).astype(np.float32)
