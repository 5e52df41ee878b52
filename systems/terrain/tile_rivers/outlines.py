"""Outlines of sets of cells: rings through the middles of the cells' edges, and as few of these as show them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ....engine.real_ground.height_grid import HeightGrid
from ..vector_water.streams import Way, simplified
from .cells import GridCells, Indices

__all__ = ["outline", "simple_line"]

Floats = NDArray[np.float64]

_LEAST_PLACES = 4
_TURNS = ((1, 0), (0, 1), (-1, 0), (0, -1))
"""Directions (columns, rows) of edges, each to the right of the one before: rows go south."""


def simple_line(grid: HeightGrid, points: Floats, tolerance_m: float) -> Indices:
    """Indices of the places (N, 2), degrees, that a line needs to stay within tolerance_m of them all."""
    count = len(points)
    fixed = np.zeros(count, dtype=bool)
    fixed[[0, -1]] = True
    nothing = np.zeros(count)
    return simplified(Way(points, nothing, nothing, np.full(count, -1), fixed), tolerance_m, grid.radius_m)


def outline(cells: GridCells, part: Indices, tolerance_m: float) -> list[Floats]:
    """Rings (K, 2), longitude and latitude in degrees, closed: the outer one, to the left, and islands, of a part that
    hangs together."""
    row, column = cells.row[part].astype(np.int64), cells.column[part].astype(np.int64)
    first = int(row.min()) - 1, int(column.min()) - 1
    mask = np.zeros((int(row.max()) - first[0] + 2, int(column.max()) - first[1] + 2), dtype=bool)
    mask[row - first[0], column - first[1]] = True
    found = []
    for ring in _rings(mask):
        places = cells.grid.degrees(ring[:, 0] + first[1], ring[:, 1] + first[0])
        kept = places[simple_line(cells.grid, places, tolerance_m)]
        if len(kept) >= _LEAST_PLACES:
            found.append(kept[::-1])
    # The outer ring has the most westerly place.
    return sorted(found, key=lambda ring: float(ring[:, 0].min()))


def _rings(mask: NDArray[np.bool_]) -> list[Floats]:
    """Closed rings (K, 2) of columns and rows, cells' middles at whole numbers, with the cells of the mask to their
    right. Cells that touch by a corner hang together."""
    edges: dict[tuple[int, int], list[int]] = {}
    inside = mask[1:-1, 1:-1]
    # Along the upper side eastwards, and so on: which neighbour is none, and at which corner the edge begins.
    sides = ((0, -1, 0, 0), (1, 0, 1, 0), (0, 1, 1, 1), (-1, 0, 0, 1))
    for turn, (di, dj, ci, cj) in enumerate(sides):
        beside = mask[1 + dj : mask.shape[0] - 1 + dj, 1 + di : mask.shape[1] - 1 + di]
        for j, i in np.argwhere(inside & ~beside).tolist():
            edges.setdefault((i + 1 + ci, j + 1 + cj), []).append(turn)
    found = []
    for begin in sorted(edges):
        while edges[begin]:
            at, turn, ring = begin, edges[begin].pop(), []
            while True:
                step = _TURNS[turn]
                ring.append((at[0] + 0.5 * step[0] - 0.5, at[1] + 0.5 * step[1] - 0.5))
                at = at[0] + step[0], at[1] + step[1]
                leaves = edges[at]
                if not leaves:
                    break
                # Where two rings touch, to the left: what touches by a corner is one.
                turn = min(leaves, key=lambda to, came=turn: (to - came + 1) % 4)
                leaves.remove(turn)
            found.append(np.array([*ring, ring[0]]))
    return found
