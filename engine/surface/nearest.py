"""The point of a cell that is nearest to a direction, exactly, in gnomonic coordinates.

On its face a cell is a rectangle [x0, x1] x [y0, y1] of gnomonic coordinates (tangents), its edges great circles. The
nearest point is inside, or the foot of the perpendicular on an edge, or a corner.
"""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_TINY = 1e-300
_AHEAD = 1e-12


class NearestPoint:
    """Distances from one direction to many cells; prepared once for the direction.

    `direction` is a unit vector (3,) in planet axes, `axes` the faces' axes (6, 3, 3).
    """

    def __init__(self, direction: Floats, axes: NDArray[np.int64]) -> None:
        self.local: Floats = (axes * direction).sum(axis=2).astype(np.float64)
        """(6, 3): the direction in each face's axes."""
        ahead = self.local[:, 2:] > _AHEAD
        side = np.copysign(1.0 / _AHEAD, self.local[:, :2])
        self.gnomonic: Floats = np.where(ahead, self.local[:, :2] / np.where(ahead, self.local[:, 2:], 1.0), side)
        """(6, 2): its gnomonic coordinates; far out to its side where it is not in front of the face."""

    def chord_squared(self, face: NDArray[np.int64], low: Floats, high: Floats) -> Floats:
        """Squared chords on the unit sphere, (N,), to the cells with gnomonic bounds low and high, (2, N) each."""
        local = self.local.T[:, face]
        z = local[2]
        swapped = local[1::-1]
        # First clamp one coordinate, then take the foot of the perpendicular on that great circle, clamped; both ways.
        first = np.clip(self.gnomonic.T[:, face], low, high)
        slope = 1.0 + first * first
        foot = swapped * slope / np.maximum(z + local[:2] * first, _TINY)
        second = np.clip(foot, low[::-1], high[::-1])
        norm = 1.0 / np.sqrt(slope + second * second)
        a = first * norm - local[:2]
        b = second * norm - swapped
        c = norm - z
        squares = a * a + b * b + c * c
        best = np.minimum(squares[0], squares[1])
        # Far round the sphere a foot may lie on the back of its great circle, and the nearest point be a corner.
        far = best > 1.0
        if far.any():
            best[far] = np.minimum(best[far], _corners(local[:, far], low[:, far], high[:, far]))
        return best


def _corners(local: Floats, low: Floats, high: Floats) -> Floats:
    """Squared chords to the nearest corner."""
    x = np.stack([low[0], high[0], low[0], high[0]])
    y = np.stack([low[1], low[1], high[1], high[1]])
    norm = 1.0 / np.sqrt(1.0 + x * x + y * y)
    return ((x * norm - local[0]) ** 2 + (y * norm - local[1]) ** 2 + (norm - local[2]) ** 2).min(axis=0)
