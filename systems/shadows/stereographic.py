"""A map of the sphere that the clipmap's texels lie on: stereographic, about the nearest of six axes, float64.

A point of direction (x, y, z) in the projection's axes has p = (x, y) / (1 + z). The map is conformal, so a texel is a
square of side 2 R h / (1 + |p|^2) everywhere, h its side on the map; there are no borders short of the antipode, and
both ways need no angles. Points are fixed to the planet: texels are those whose p / h are whole numbers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["PROJECTIONS", "Stereographic", "nearest_projection"]

Floats = NDArray[np.float64]

_HYSTERESIS = 1.02
"""By how much nearer (in cosine) another axis has to be before it takes over."""


@dataclass(frozen=True, eq=False)
class Stereographic:
    """One of the six. axes: (3, 3), rows x, y, z in planet axes; z points to its centre."""

    number: int
    axes: Floats

    def place(self, direction: Floats) -> Floats:
        """p (..., 2) of unit directions (..., 3). Infinite at the antipode of its centre."""
        local = np.asarray(direction, np.float64) @ self.axes.T
        return local[..., :2] / (1.0 + local[..., 2:])

    def direction(self, place: Floats) -> Floats:
        """Unit direction (..., 3) of p (..., 2)."""
        p = np.asarray(place, np.float64)
        square = (p * p).sum(axis=-1, keepdims=True)
        local = np.concatenate([2.0 * p, 1.0 - square], axis=-1) / (1.0 + square)
        return local @ self.axes

    @staticmethod
    def scale(place: Floats) -> float:
        """Length on the unit sphere per length on the map."""
        return 2.0 / (1.0 + float(place @ place))


def _projections() -> tuple[Stereographic, ...]:
    found = []
    for number in range(6):
        axis, sign = divmod(number, 2)
        z = np.zeros(3)
        z[axis] = 1.0 - 2.0 * sign
        x = np.zeros(3)
        x[(axis + 1) % 3] = 1.0
        found.append(Stereographic(number, np.stack([x, np.cross(z, x), z])))
    return tuple(found)


PROJECTIONS = _projections()
"""About +X -X +Y -Y +Z -Z."""


def nearest_projection(direction: Floats, previous: Stereographic | None = None) -> Stereographic:
    """The projection to use at a unit direction (3,): `previous` while no other is clearly nearer."""
    x, y, z = direction.tolist()
    cosines = (x, -x, y, -y, z, -z)
    best = cosines.index(max(cosines))
    if previous is not None and cosines[best] < _HYSTERESIS * cosines[previous.number] and cosines[best] < 1.0:
        return previous
    return PROJECTIONS[best]
