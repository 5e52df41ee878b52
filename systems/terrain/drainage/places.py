"""Places in a cell where its river may run: rivers through the cells' middles would show their lattice.

Each cell has five, by a hash of its number: one about its middle and one in each quarter, none further than 0.35 of the
cell's width from its middle along either axis. The river takes the lowest, and then its corners are rounded.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ....engine.surface.noise import pcg3d
from .cells import CellGrid, Cells

__all__ = ["FINER", "OFFSET", "PLACES", "offset_directions", "place_directions", "place_offsets", "smoothed"]

Floats = NDArray[np.float64]
Offsets = NDArray[np.int8]

PLACES = 5
_MIDDLES = np.array([(0.0, 0.0), (-0.2, -0.2), (0.2, -0.2), (-0.2, 0.2), (0.2, 0.2)])
_SPREAD = 0.15
"""Furthest from these, in cells."""
FINER = 0.25
"""Relief of the ground's layers that cells don't show, by how far the lowest of a cell's places lies below their mean:
by so much its low ground is lower still."""
OFFSET = 1.0 / 256.0
"""Offsets from a cell's middle are kept in these, in cells."""
_INNER = 120
"""Furthest offset: a place stays in its cell."""
_SMOOTH = 0.17
"""How far a place is drawn to each of those before and after it: 1/8 makes the corners of a B-spline (Chaikin's and
Catmull and Clark's rules), more leaves fewer corners of the lattice."""


def place_offsets(cells: Cells, place: NDArray[np.uint8] | int) -> Offsets:
    """Offsets (N, 2) of a place, 0..PLACES - 1 or (N,) of these, from the middle of each of cells (N,)."""
    number = np.asarray(cells).astype(np.uint32)
    which = np.broadcast_to(np.asarray(place, dtype=np.uint32), number.shape)
    x, y, _ = pcg3d(number, which, np.full_like(number, 7))
    hashed = np.stack([(word >> np.uint32(8)).astype(np.float64) for word in (x, y)], axis=1)
    return np.rint((_MIDDLES[which] + (hashed * 2.0**-23 - 1.0) * _SPREAD) / OFFSET).astype(np.int8)


def offset_directions(grid: CellGrid, cells: Cells, offset: Offsets) -> Floats:
    """Unit directions (N, 3) at offsets (N, 2) in cells (N,)."""
    return grid.within(cells, offset.astype(np.float64) * OFFSET)


def place_directions(grid: CellGrid, cells: Cells, place: NDArray[np.uint8] | int) -> Floats:
    """Unit directions (N, 3) of a place in each of cells (N,)."""
    return offset_directions(grid, cells, place_offsets(cells, place))


def smoothed(grid: CellGrid, cells: Cells, here: Floats, before: Floats, after: Floats) -> Offsets:
    """Offsets (N, 2) of places here (N, 3) drawn towards those before and after them on their way, in their cells."""
    drawn = here + _SMOOTH * (before - here + (after - here))
    offset = np.rint(grid.offsets(cells, drawn) / OFFSET)
    return np.minimum(np.maximum(offset, -_INNER), _INNER).astype(np.int8)
