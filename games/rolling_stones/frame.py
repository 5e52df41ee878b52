"""A local frame on the planet, and rotations between frames. Everything in float64."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class LocalFrame:
    """origin_m: planet-centred (3,). axes: rows east, north, up in planet axes (3, 3)."""

    origin_m: Floats
    axes: Floats

    @classmethod
    def at(cls, origin_m: Floats) -> LocalFrame:
        """Upright at a place away from the poles."""
        up = origin_m / np.linalg.norm(origin_m)
        east = np.cross([0.0, 0.0, 1.0], up)
        east /= np.linalg.norm(east)
        return cls(origin_m, np.stack([east, np.cross(up, east), up]))

    def to_planet(self, points: Floats) -> Floats:
        """Positions (N, 3) in planet axes of points (N, 3) in the frame."""
        return self.origin_m + points @ self.axes

    def to_local(self, positions_m: Floats) -> Floats:
        return (positions_m - self.origin_m) @ self.axes.T

    @property
    def quaternion(self) -> Floats:
        """(x, y, z, w) that turns the frame's axes into the planet's."""
        return quaternion_of(self.axes.T)


def quaternion_of(matrix: Floats) -> Floats:
    """Quaternion (x, y, z, w) of a rotation matrix (3, 3): the eigenvector of Bar-Itzhack 2000, for any angle."""
    m = matrix
    k = np.array(
        [
            [m[0, 0] - m[1, 1] - m[2, 2], m[1, 0] + m[0, 1], m[2, 0] + m[0, 2], m[2, 1] - m[1, 2]],
            [m[1, 0] + m[0, 1], m[1, 1] - m[0, 0] - m[2, 2], m[2, 1] + m[1, 2], m[0, 2] - m[2, 0]],
            [m[2, 0] + m[0, 2], m[2, 1] + m[1, 2], m[2, 2] - m[0, 0] - m[1, 1], m[1, 0] - m[0, 1]],
            [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], m[0, 0] + m[1, 1] + m[2, 2]],
        ]
    )
    return np.linalg.eigh(k)[1][:, -1]


def product(a: Floats, b: Floats) -> Floats:
    """Quaternions (..., 4): first b, then a."""
    x, y, z, w = np.moveaxis(a, -1, 0)
    i, j, k, r = np.moveaxis(b, -1, 0)
    return np.stack(
        [w * i + x * r + y * k - z * j, w * j - x * k + y * r + z * i, w * k + x * j - y * i + z * r,
         w * r - x * i - y * j - z * k], axis=-1,
    )  # fmt: skip


def inverse(q: Floats) -> Floats:
    """Of unit quaternions (..., 4)."""
    return q * np.array([-1.0, -1.0, -1.0, 1.0])
