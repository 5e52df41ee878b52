"""Places in a cell where its river may run: rivers through the cells' middles would show their lattice.

Each cell has five, by a hash of its number: one about its middle and one in each quarter, none further than 0.35 of the
cell's width from its middle along either axis, so that a place always lies in its cell. The river takes the lowest.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ....engine.surface.noise import pcg3d
from .cells import Cells, CellGrid

__all__ = ["PLACES", "place_directions"]

PLACES = 5
_MIDDLES = np.array([(0.0, 0.0), (-0.2, -0.2), (0.2, -0.2), (-0.2, 0.2), (0.2, 0.2)])
_SPREAD = 0.15
"""Furthest from these, in cells."""


def place_directions(grid: CellGrid, cells: Cells, place: NDArray[np.uint8] | int) -> NDArray[np.float64]:
    """Unit directions (N, 3) of a place, 0..PLACES - 1 or (N,) of these, in each of cells (N,)."""
    number = np.asarray(cells).astype(np.uint32)
    which = np.broadcast_to(np.asarray(place, dtype=np.uint32), number.shape)
    x, y, _ = pcg3d(number, which, np.full_like(number, 7))
    hashed = np.stack([(word >> np.uint32(8)).astype(np.float64) for word in (x, y)], axis=1)
    return grid.within(cells, _MIDDLES[which] + (hashed * 2.0**-23 - 1.0) * _SPREAD)
