"""3D simplex noise on integer cells: the float64 twin of `assets/shaders/common/simplex.glsl`.

Perlin's simplex noise (2001) as Gustavson describes it ("Simplex noise demystified", 2005), with two differences:
gradients come from the PCG3D hash (so that CPU and GPU agree on every bit of the lattice), and a corner's kernel is
(1/2 - r^2)^4, which ends within its own simplices; with the usual 0.6 the noise jumps at their faces by 1e-3.

A point is a cell of the skewed lattice and a fraction of it: a point p of space has skewed coordinates p + (p.1)/3.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .noise import GRADIENT_SCALE, pcg3d

Floats = NDArray[np.float64]

SIMPLEX_SCALE = 60.0
"""Brings the noise to (-1, 1): with all gradient components at most 1 the four kernels add up to 0.965 at most."""
SIMPLEX_BOUND = 1.0
"""|simplex_noise| stays below this."""


def skew(points: Floats) -> Floats:
    """Skewed coordinates of `points` (..., 3): cells are unit cubes there."""
    return points + points.sum(axis=-1, keepdims=True) / 3.0


def simplex_noise(points: Floats) -> Floats:
    """Simplex noise (N,) at `points` (N, 3), in wavelengths."""
    skewed = skew(points)
    cell = np.floor(skewed)
    return simplex_in_cell(cell.astype(np.int64), skewed - cell)


def simplex_in_cell(cell: NDArray[np.int64], f: Floats) -> Floats:
    """Simplex noise (N,) in integer cells (N, 3) at skewed fractions f (N, 3) in [0, 1)."""
    words = cell.astype(np.uint32)
    # Whether a component is the largest, and whether it is the smallest; ties may fall either way, if only one does.
    x, y, z = f.T
    xy, xz, yz = x >= y, x >= z, y >= z
    first = np.stack([xy & xz, ~xy & yz, ~(xz & xy) & ~(~xy & yz)], axis=1)
    last = np.stack([~xy & ~xz, xy & ~yz, ~(~xy & ~xz) & ~(xy & ~yz)], axis=1)
    origin = f - f.sum(axis=1, keepdims=True) / 6.0
    total = np.zeros(len(f))
    corners = (np.zeros_like(first), first, ~last, np.ones_like(first))
    for number, step in enumerate(corners):
        offset = origin - step + number / 6.0
        t = np.maximum(0.5 - (offset * offset).sum(axis=1), 0.0)
        h = pcg3d(*(words + step.astype(np.uint32)).T)
        g = np.stack([(w.view(np.int32) >> 8) * GRADIENT_SCALE for w in h], axis=1)
        total += t**4 * (g * offset).sum(axis=1)
    return SIMPLEX_SCALE * total


__all__ = ["SIMPLEX_BOUND", "SIMPLEX_SCALE", "simplex_in_cell", "simplex_noise", "skew"]
