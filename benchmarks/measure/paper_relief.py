"""Relief of the printed grid's ground beside the scene's own."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...engine.surface.field import HeightField

Floats = NDArray[np.float64]

WIDTH_M = 100e3
"""Of the square whose relief is compared, on a planet of Earth's size."""
_SAMPLES = 40


def square_around(direction: Floats, width_m: float, radius_m: float, samples: int = _SAMPLES) -> Floats:
    """Unit directions (samples^2, 3) of a square on the sphere."""
    helper = np.eye(3)[int(np.argmin(np.abs(direction)))]
    u = np.cross(direction, helper)
    u = u / np.linalg.norm(u)
    v = np.cross(direction, u)
    at = ((np.arange(samples) + 0.5) / samples - 0.5) * width_m
    x, y = (a.ravel()[:, None] for a in np.meshgrid(at, at))
    points = direction * radius_m + x * u + y * v
    return np.asarray(points / np.linalg.norm(points, axis=1, keepdims=True))


def relief_m(field: HeightField, direction: Floats, radius_m: float) -> float:
    """Standard deviation of the heights within the square."""
    width_m = WIDTH_M * radius_m / 6.371e6
    return float(field.height(square_around(direction, width_m, radius_m)).std())
