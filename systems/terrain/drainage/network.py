"""The rivers of a planet: every cell of land with the way that its water takes, and the streams along these ways."""

from __future__ import annotations

import hashlib
import logging
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ....engine.table_cache import TableCache
from ..height import height
from ..height_params import TerrainParams
from .cells import NO_CELL, CellGrid, cell_grid
from .climate import ACROSS, ClimateParams, rain_mm, runoff_mm, temperature_c
from .routing import Flow, add_downstream, flow_of, levels_of

__all__ = ["CELLS", "YEAR_S", "Network", "Stream", "network_of", "solve"]

log = logging.getLogger(__name__)

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

CELLS = 3_538_944
"""Of a planet, 6 x 768^2: 12 km on Earth, a million of them land."""
_VERSION = "1"
"""Part of the cache's key: change it with what this module and its neighbours compute."""
_LEAST_ACROSS = 16
_LAYERS = 6
"""Of the ground's relief that cells can show: down to 4 km."""
_AIR_LAYERS = 2
"""The same of the cells on which air moves: down to 65 km."""
YEAR_S = 365.2425 * 86400.0
_BLOCK = 1 << 16


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
    runoff_mm: Floats
    """water of a year that runs off a cell"""

    @cached_property
    def directions(self) -> Floats:
        """Unit directions (N, 3) of the cells' middles."""
        return self.grid.directions(self.cells)

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

    def streams(self, most: int) -> list[Stream]:
        """The rivers with the most water where they end, the largest first. At a confluence the branch with more water
        keeps its name; of equals, as in dry valleys, that with more land."""
        receiver, land = self.receiver, np.flatnonzero(~self.sea)
        # From little to much, so that the last to be written is the largest.
        by_water = land[np.lexsort((-land, self.catchment_m2[land], self.discharge_m3_s[land]))]
        main = np.full(len(receiver), -1)
        main[receiver[by_water]] = by_water
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


def solve(
    params: TerrainParams,
    climate: ClimateParams,
    cells: int = CELLS,
    progress: Callable[[float], None] | None = None,
) -> Network:
    """Rivers of a ground, computed: a few seconds for a million cells of land.

    cells: of the whole sphere, rounded to 6 n^2, at least 6 x 16^2. Land is what lies above height 0, and its water
    ends where it comes to what does not. ValueError for ground that has no land, or nothing else.
    """
    grid = cell_grid(_across(cells))
    told = progress or (lambda share: None)
    broad = replace(params, layers=min(params.layers, _LAYERS))
    heights = _heights(grid, broad, lambda share: told(0.6 * share))
    land = np.flatnonzero(heights > 0.0).astype(np.int32)
    if not 0 < len(land) < grid.count:
        raise ValueError("drainage: all ground lies above height 0, or below: there is no land whose water has an end")
    coarse = cell_grid(ACROSS)
    rain = rain_mm(coarse, _heights(coarse, replace(params, layers=min(params.layers, _AIR_LAYERS))), climate)
    told(0.75)
    around = grid.neighbours(land)
    around = around[around != NO_CELL]
    kept = np.union1d(land, around[heights[around] <= 0.0]).astype(np.int32)
    index = np.full(grid.count, -1, dtype=np.int64)
    index[kept] = np.arange(len(kept))
    neighbours = grid.neighbours(kept).astype(np.int64)
    neighbours = np.where(neighbours == NO_CELL, -1, index[neighbours])
    directions, height_m = grid.directions(kept), heights[kept]
    told(0.85)
    flow = flow_of(height_m, height_m <= 0.0, neighbours, _distances(directions, neighbours))
    falls = np.maximum(coarse.interpolated(rain, directions), 0.0)
    # Whole millimetres: what is kept on disk gives the same rivers.
    runs = np.rint(np.minimum(runoff_mm(falls, temperature_c(directions, height_m, climate)), 65535.0))
    log.info("%d cells of land, %d hollows, %d steps from the sea", len(land), flow.hollows, len(flow.starts) - 2)
    told(1.0)
    return Network(grid, params.radius_m, kept, flow.receiver, runs)


def network_of(
    params: TerrainParams,
    climate: ClimateParams,
    cells: int = CELLS,
    progress: Callable[[float], None] | None = None,
    cache: TableCache | None = None,
) -> Network:
    """As `solve`, from the user's cache folder where it has been solved before."""
    cache = TableCache("drainage") if cache is None else cache
    grid = cell_grid(_across(cells))
    map_ = params.height_map
    content = "" if map_ is None else hashlib.sha256(map_.cube.levels[0].tobytes()).hexdigest()
    key = cache.key(_VERSION, str(grid.across), repr(replace(params, height_map=None)), content, repr(climate))
    shape = (grid.count,)
    held = cache.load(key, {"step": shape, "runoff_mm": shape}, np.uint16)
    if held is not None:
        if progress is not None:
            progress(1.0)
        found = np.flatnonzero(held["step"] < _OPEN_SEA).astype(np.int32)
        return _unpacked(grid, params.radius_m, found, held["step"][found], held["runoff_mm"][found])
    made = solve(params, climate, cells, progress)
    step, runoff = np.full(shape, _OPEN_SEA, dtype=np.uint8), np.zeros(shape, dtype=np.uint16)
    step[made.cells], runoff[made.cells] = _steps(made), made.runoff_mm
    cache.save(key, {"step": step, "runoff_mm": runoff})
    return made


def _across(cells: int) -> int:
    return max(_LEAST_ACROSS, round((cells / 6.0) ** 0.5))


_SHORE, _OPEN_SEA = 8, 255
"""In place of the number of the neighbour that a cell's water goes to."""


def _steps(network: Network) -> NDArray[np.uint8]:
    neighbours = network.grid.neighbours(network.cells)
    to = network.cells[network.receiver]
    step = np.argmax(neighbours == to[:, None], axis=1)
    return np.where(network.sea, _SHORE, step).astype(np.uint8)


def _unpacked(
    grid: CellGrid, radius_m: float, cells: NDArray[np.int32], step: NDArray[np.uint16], runoff: NDArray[np.uint16]
) -> Network:
    neighbours = grid.neighbours(cells)
    number = np.concatenate([neighbours, cells[:, None]], axis=1)[np.arange(len(cells)), step]
    return Network(grid, radius_m, cells, np.searchsorted(cells, number), runoff.astype(np.float64))


def _heights(grid: CellGrid, params: TerrainParams, told: Callable[[float], None] | None = None) -> Floats:
    """Of all cells, on all processors: numpy lets others work meanwhile."""
    edges = [*range(0, grid.count, _BLOCK), grid.count]

    def part(bounds: tuple[int, int]) -> Floats:
        return height(grid.directions(np.arange(*bounds, dtype=np.int32)), params)

    found = []
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for number, heights in enumerate(pool.map(part, pairwise(edges))):
            found.append(heights)
            if told is not None:
                told((number + 1) / (len(edges) - 1))
    return np.concatenate(found)


def _distances(directions: Floats, neighbours: Indices) -> Floats:
    """(N, 8), in radii; 1 where there is no neighbour."""
    found = np.ones(neighbours.shape)
    for k in range(neighbours.shape[1]):
        x, y, z = (directions - directions[neighbours[:, k]]).T
        found[:, k] = np.where(neighbours[:, k] >= 0, np.sqrt(x * x + y * y + z * z), 1.0)
    return found
