"""Cells of a grid of heights that water runs over, and the ways between them, as drainage/routing.py asks for them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....engine.real_ground.height_grid import HeightGrid

__all__ = ["AROUND", "GridCells", "Indices", "cells_of", "regions"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

AROUND = ((0, -1), (-1, 0), (1, 0), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1))
"""Steps (columns, rows) to the neighbours."""
_OUT_M = -1e9
"""Height of what lies beyond the data: water that comes to its border may leave there."""
_HINT = 2.0**-12
"""Share of the ground's broad shape that counts: it says which way is down where whole metres are all alike."""


@dataclass(frozen=True, eq=False)
class GridCells:
    """Cells with a height, (N,) in the order of rows, and one more, the last: what lies beyond the data.

    height_m: as the grid has it; routed_m: the same with a hint of the ground's broad shape; sea: cells that water
    ends at, the last is one. neighbours, distance_m (N + 1, 9): the ninth is the way out, infinitely long where another
    leads down, away from the border. area_m2: 0 in the sea.
    """

    grid: HeightGrid
    number: NDArray[np.int32]
    """(rows, columns), -1 where there is no height"""
    row: NDArray[np.int32]
    column: NDArray[np.int32]
    height_m: Floats
    routed_m: Floats
    sea: NDArray[np.bool_]
    neighbours: NDArray[np.int32]
    distance_m: NDArray[np.float32]
    area_m2: Floats
    border: NDArray[np.bool_]
    """land next to where there is no data"""

    @property
    def out(self) -> int:
        """Index of what lies beyond the data."""
        return len(self.row)

    def places(self, cells: Indices, offset: Floats | None = None) -> Floats:
        """(K, 2) longitude and latitude, degrees, of cells' middles, or of places off them by columns and rows."""
        column, row = self.column[cells].astype(np.float64), self.row[cells].astype(np.float64)
        if offset is not None:
            column, row = column + offset[:, 0], row + offset[:, 1]
        return self.grid.degrees(column, row)


def cells_of(grid: HeightGrid, sea_m: float) -> GridCells:
    """Water ends at cells that are not above sea_m."""
    there = ~np.isnan(grid.height_m)
    count = int(there.sum())
    number = np.full(there.shape, -1, dtype=np.int32)
    number[there] = np.arange(count, dtype=np.int32)
    row, column = (v.astype(np.int32) for v in np.nonzero(there))
    height = np.append(grid.height_m[there], _OUT_M)
    broad = _broad(grid.height_m, there)[there]
    routed = height.copy()
    routed[:-1] += _HINT * (broad - height[:-1])
    sea = height <= sea_m
    wide = np.pad(number, 1, constant_values=-1)
    neighbours = np.full((count + 1, len(AROUND) + 1), -1, dtype=np.int32)
    distance = np.ones(neighbours.shape, dtype=np.float32)
    per_m = grid.radius_m * grid.column_rad
    east_m = per_m * np.cos(np.radians(grid.latitude_deg))
    rows_m = np.append(np.abs(np.diff(np.radians(grid.latitude_deg))), 0.0) * grid.radius_m
    for k, (di, dj) in enumerate(AROUND):
        neighbours[:-1, k] = wide[row + 1 + dj, column + 1 + di]
        north_m = rows_m[row - 1] if dj < 0 else rows_m[row] if dj > 0 else 0.0
        distance[:-1, k] = np.maximum(np.hypot(abs(di) * east_m[row], north_m), 1e-3)
    border = np.append((neighbours[:-1, :-1] < 0).any(axis=1), False) & ~sea
    neighbours[border, -1] = count
    distance[:, -1] = np.inf
    distance[_leaving(routed, neighbours, distance, border), -1] = 1.0
    strip = np.abs(np.diff(np.sin(np.radians(grid.edge_deg)))) * (per_m * grid.radius_m)
    area = np.append(strip[row], 0.0)
    area[sea] = 0.0
    return GridCells(grid, number, row, column, height, routed, sea, neighbours, distance, area, border)


def _leaving(
    height: Floats, neighbours: NDArray[np.int32], distance: NDArray[np.float32], border: NDArray[np.bool_]
) -> Indices:
    """Cells on the border whose way down doesn't lead away from it: nobody knows the ground beyond, and water
    that ran along the border would come together there to rivers that are none."""
    at = np.flatnonzero(border)
    to = neighbours[at, :-1]
    slope = np.where(to >= 0, height[at, None] - height[to], -1.0) / distance[at, :-1]
    best = np.argmax(slope, axis=1)
    own = np.arange(len(at))
    return at[(slope[own, best] <= 0.0) | border[to[own, best]]]


def _broad(height: Floats, there: NDArray[np.bool_]) -> Floats:
    """Means of the ground (rows, columns) over 7 and over 31 cells, of both the mean: 3 x 3 cells again and again,
    twice as far apart each time."""
    mean = np.where(there, height, 0.0)
    found = []
    for apart in (1, 2, 4, 8):
        mean = _mean3(_mean3(mean, there, apart, 0), there, apart, 1)
        if apart in (2, 8):
            found.append(mean)
    return 0.5 * (found[0] + found[1])


def _mean3(values: Floats, there: NDArray[np.bool_], apart: int, axis: int) -> Floats:
    """Of each cell and those `apart` before and behind it along an axis, of those that are there."""
    total, count = values * there, there.astype(np.float64)
    size = values.shape[axis]
    if size > apart:
        for a, b in (((apart, size), (0, size - apart)), ((0, size - apart), (apart, size))):
            to, of = (tuple(slice(*v) if n == axis else slice(None) for n in (0, 1)) for v in (a, b))
            total[to] += values[of] * there[of]
            count[to] += there[of]
    return total / np.maximum(count, 1.0)


def regions(cells: GridCells, wanted: NDArray[np.bool_], key: Floats) -> Indices:
    """(N + 1,) of the cells that are wanted the lowest index of those that hang together with it and have the same key;
    -1 elsewhere."""
    label = np.where(wanted, np.arange(len(wanted)), -1)
    at = np.flatnonzero(wanted)
    pairs = []
    for k in range(len(AROUND)):
        to = cells.neighbours[at, k].astype(np.int64)
        near = np.flatnonzero(to > at)
        a, b = at[near], to[near]
        same = wanted[b] & (key[a] == key[b])
        pairs.append(np.stack([a[same], b[same]]))
    a, b = np.concatenate(pairs, axis=1)
    while len(a):
        high, low = np.maximum(label[a], label[b]), np.minimum(label[a], label[b])
        apart = high != low
        a, b, high, low = a[apart], b[apart], high[apart], low[apart]
        np.minimum.at(label, high, low)
        while True:
            further = label[label[at]]
            if np.array_equal(further, label[at]):
                break
            label[at] = further
    return label
