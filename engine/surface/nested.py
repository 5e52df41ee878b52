"""The anchor of nested noise: one integer place from which the lattices of all wavelengths follow by shifts.

Used by shaders that choose their wavelengths pixel by pixel (assets/shaders/common/nested_noise.glsl).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..blocks.layout import IVec3, Vec3

__all__ = ["NESTED_BASE_M", "NestedAnchor", "nested_anchor"]

NESTED_BASE_M = 0.0625
"""Shortest wavelength; the others are this times powers of two. With it 1e8 m still fit into int32."""


@dataclass
class NestedAnchor:
    """A place in units of NESTED_BASE_M."""

    cell: IVec3
    fraction: Vec3


def nested_anchor(direction: NDArray[np.float64], radius_m: float) -> NestedAnchor:
    """The anchor's foot (unit `direction` (3,), float64)."""
    x, y, z = (np.asarray(direction, dtype=np.float64).reshape(3) * (radius_m / NESTED_BASE_M)).tolist()
    i, j, k = math.floor(x), math.floor(y), math.floor(z)
    return NestedAnchor((i, j, k), (x - i, y - j, z - k))
