"""The rivers of a planet: every cell of land with the way that its water takes, and the streams along these ways."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .cells import CellGrid
from .places import offset_directions
from .routing import Flow, add_downstream, levels_of

__all__ = ["CELLS", "YEAR_S", "Network", "Stream"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

CELLS = 3_538_944
"""Of a planet, 6 x 768^2: 12 km on Earth, a million of them land."""
YEAR_S = 365.2425 * 86400.0


@dataclass(frozen=True)
class Stream:
    """A river from its spring to where it ends, by indices of a Network's cells."""

    cells: Indices
    """(K,) downstream; the last is the sea's, or the first that it shares with a larger river"""
    into: int
    """which of the streams it joins; -1: none, it reaches the sea"""


@dataclass(frozen=True, eq=False)
class Network:
    """Cells of land and of the shore, (N,) in all, in the order of their numbers; by index where nothing else is said.

    The shore's cells are the sea's first: water ends there.
    """

    grid: CellGrid
    radius_m: float
    cells: NDArray[np.int32]
    """their numbers in the grid"""
    receiver: Indices
    """where a cell's water goes; itself in the sea"""
    offset: NDArray[np.int8]
    """(N, 2) where in the cell the water runs, see places.py"""
    runoff_mm: Floats
    """water of a year that runs off a cell"""

    @cached_property
    def directions(self) -> Floats:
        """Unit directions (N, 3) of the cells' middles."""
        return self.grid.directions(self.cells)

    @cached_property
    def places(self) -> Floats:
        """Unit directions (N, 3) of where water runs in the cells; their middles in the sea."""
        found = offset_directions(self.grid, self.cells, self.offset)
        return np.where(self.sea[:, None], self.directions, found)

    @cached_property
    def sea(self) -> NDArray[np.bool_]:
        """The shore's cells."""
        return self.receiver == np.arange(len(self.receiver))

    @cached_property
    def flow(self) -> Flow:
        """Cells by level."""
        return Flow(self.receiver, *levels_of(self.receiver), hollows=0)

    @cached_property
    def area_m2(self) -> Floats:
        """Of each cell."""
        return self.grid.areas(self.directions) * (self.radius_m * self.radius_m)

    @cached_property
    def catchment_m2(self) -> Floats:
        """Of each cell and all land whose water comes through it; the shore's cells count for nothing themselves."""
        return add_downstream(self.flow, np.where(self.sea, 0.0, self.area_m2))

    @cached_property
    def discharge_m3_s(self) -> Floats:
        """Mean of the year of what leaves each cell."""
        own = np.where(self.sea, 0.0, self.area_m2 * self.runoff_mm * (1e-3 / YEAR_S))
        return add_downstream(self.flow, own)

    @cached_property
    def mouth(self) -> Indices:
        """The shore's cell that water of each ends in: cells of one basin have the same."""
        end = self.receiver
        while not np.array_equal(end[end], end):
            end = end[end]
        return end

    @cached_property
    def index(self) -> Indices:
        """(grid.count,): index of each of the grid's cells, -1 for the open sea's."""
        found = np.full(self.grid.count, -1, dtype=np.int64)
        found[self.cells] = np.arange(len(self.cells))
        return found

    @cached_property
    def _by_water(self) -> Indices:
        """Cells of land from little water to much; of equals, as in dry valleys, from little land to much."""
        land = np.flatnonzero(~self.sea)
        return land[np.lexsort((-land, self.catchment_m2[land], self.discharge_m3_s[land]))]

    @cached_property
    def main(self) -> Indices:
        """(N,) of the cells whose water comes to each the one with the most; -1: none."""
        found = np.full(len(self.receiver), -1)
        found[self.receiver[self._by_water]] = self._by_water  # the last to be written is the largest
        return found

    def streams(self, most: int) -> list[Stream]:
        """The rivers with the most water where they end, the largest first. At a confluence the branch with more water
        keeps its name; of equals, as in dry valleys, that with more land."""
        receiver, by_water, main = self.receiver, self._by_water, self.main
        # Into the sea each goes for itself.
        ends = (main[receiver[by_water]] != by_water) | self.sea[receiver[by_water]]
        owner, found = np.full(len(receiver), -1), []
        for number, end in enumerate(by_water[ends][::-1][:most]):
            way = [int(receiver[end]), int(end)]
            while main[way[-1]] >= 0:
                way.append(int(main[way[-1]]))
            owner[way[1:]] = number
            found.append(np.array(way[::-1]))
        return [Stream(way, -1 if self.sea[way[-1]] else int(owner[way[-1]])) for way in found]
