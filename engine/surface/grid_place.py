"""Where a projected grid lies, and when it moves (Michelic et al. 2019: snapped to where samples are found again).

The grid's middle is held while the camera's foot stays within CELLS of its cells; then the grid goes on by whole ones,
turned about its own axes, at the same z_s. In the middle, where all cells are alike, its points come to lie on old
ones. The warp isn't the same everywhere, so farther out they miss these by a share of their distance that grows:
by s / s0 - 1 + x s' / s of it along the way, s the third coordinate and s0 that of the middle. One cell at a time
is the least that all points can move by and be found again.

z_s is held as long as it covers what is seen and is no more than LOOSE of it; then the grid is placed anew.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from .coverage import Coverage
from .projected_grid import LOWEST_OFFSET, ProjectedGrid, grid_axes, grid_offset

__all__ = ["CELLS", "LOOSE", "MOST_CELLS", "SPARE", "cell_rad", "moved", "placed", "reach_rad", "turned"]

Floats = NDArray[np.float64]

CELLS = 0.7
"""How far from the middle of the grid a camera's foot may be, in cells along either axis: half a cell and some slack,
so that one on a border doesn't switch to and fro."""
LOOSE = 1.2
"""How much farther from the centre of the planet the middle of a new grid may lie than that of the one that is held."""
SPARE = 1.03
"""How much nearer to the centre a new grid's middle lies than it has to: a camera's altitude varies a little."""
MOST_CELLS = 8
"""A camera that is farther away has cut: nothing of the old grid is looked for."""


def cell_rad(z_s: float, corners: int) -> float:
    """The angle of a cell in the middle of a grid of `corners` points a side."""
    return math.atan2(2.0 / (corners - 1), 1.0 + z_s)


def reach_rad(z_s: float, corners: int) -> float:
    """How far a camera's foot may be from the middle."""
    return math.sqrt(2.0) * CELLS * cell_rad(z_s, corners)


def placed(
    held: ProjectedGrid | None, foot: Floats, camera: Floats, seen: Coverage, corners: int, power: int, radius_m: float
) -> ProjectedGrid:
    """The grid for a camera: `held` itself, the same moved by whole cells, or one placed anew at `foot`.

    foot, camera: unit directions (3,); seen: what a camera sees that is over the middle of the grid."""
    z_s = _offset(seen, corners)
    if held is not None and (held.corners, held.power, held.radius_m) == (corners, power, radius_m):
        covers = held.z_s <= z_s and 1.0 + z_s <= LOOSE * (1.0 + held.z_s)
        found = moved(held, camera) if covers else None
        if found is not None:
            return found
    spare = max((1.0 + z_s) / SPARE - 1.0, LOWEST_OFFSET)
    fresh = ProjectedGrid(corners, power, spare, grid_axes(foot), radius_m)
    return moved(fresh, camera) or replace(fresh, axes=grid_axes(camera))


def moved(grid: ProjectedGrid, camera: Floats) -> ProjectedGrid | None:
    """The grid by whole cells on its way to the camera's foot; None where that is far away."""
    cell = cell_rad(grid.z_s, grid.corners)
    for _ in range(2 * MOST_CELLS):
        aside = grid.axes @ camera
        if aside[2] <= 0.0:
            return None
        cells = np.arctan2(aside[:2], aside[2]) / cell
        axis = int(np.argmax(np.abs(cells)))
        if abs(cells[axis]) > MOST_CELLS:
            return None
        if abs(cells[axis]) <= CELLS:
            return grid
        grid = replace(grid, axes=turned(grid.axes, axis, math.copysign(cell, cells[axis])))
    return grid


def turned(axes: Floats, axis: int, angle_rad: float) -> Floats:
    """Axes (3, 3) after the third has gone that far towards one of the others."""
    cosine, sine = math.cos(angle_rad), math.sin(angle_rad)
    along, up = axes[axis], axes[2]
    found = axes.copy()
    found[axis], found[2] = cosine * along - sine * up, cosine * up + sine * along
    # Rounding doesn't add up over a flight.
    found[2] /= np.linalg.norm(found[2])
    found[axis] -= (found[axis] @ found[2]) * found[2]
    found[axis] /= np.linalg.norm(found[axis])
    found[1 - axis] = np.cross(found[2], found[0]) if axis == 0 else np.cross(found[1], found[2])
    return found


def _offset(seen: Coverage, corners: int) -> float:
    """z_s for cameras that are up to `reach_rad` from the middle; what they see is that much farther."""
    z_s = grid_offset(seen)
    for _ in range(3):  # the cells get wider as the grid does: converges by the reach over the arc
        angle = min(seen.half_angle_rad + reach_rad(z_s, corners), math.pi - 1e-3)
        z_s = grid_offset(replace(seen, half_angle_rad=angle, z_s=1.0 / math.tan(angle)))
    return z_s
