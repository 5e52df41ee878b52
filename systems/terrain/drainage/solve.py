"""From a ground to its rivers: heights of cells, rain, carved levels, and the streams with their valleys."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..height import height
from ..height_octaves import model_of
from ..height_params import TerrainParams
from .carve import INCISION, CellGround, carve, lowered
from .cells import NO_CELL, CellGrid, cell_grid
from .climate import ACROSS, ClimateParams, rain_mm, runoff_mm, temperature_c
from .network import CELLS, Network
from .places import FINER, PLACES, place_directions, place_offsets, smoothed
from .routing import add_downstream, flow_of
from .streams import StreamCells
from .valleys import stream_cells

__all__ = ["Solution", "across_of", "rain_of", "solve", "solve_streams", "uncarved"]

log = logging.getLogger(__name__)

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

_LEAST_ACROSS = 16
_LAYERS = 6
"""Of the ground's relief that cells can show: down to 4 km."""
_GROUND_LAYERS = 10
"""Of the ground on which the shore is looked for: down to 256 m. No river depends on finer ones."""
_AIR_LAYERS = 2
"""The same of the cells on which air moves: down to 65 km."""
_BLOCK = 1 << 16
_SAMPLED_CELLS = 1.9
"""Catchment, in mean cells, from which on a cell's low ground is looked for."""


@dataclass(frozen=True, eq=False)
class Solution:
    """What the ground and the climate give."""

    network: Network
    streams: StreamCells


def solve(
    params: TerrainParams,
    climate: ClimateParams,
    cells: int = CELLS,
    progress: Callable[[float], None] | None = None,
    incision: float = INCISION,
) -> Network:
    """Rivers of a ground, computed: some 15 s for a million cells of land.

    cells: of the whole sphere, rounded to 6 n^2, at least 6 x 16^2. Land is what lies above height 0, and its water
    ends where it comes to what does not. incision: see carve.py. ValueError for ground that has no land, or nothing
    else.
    """
    return solve_streams(params, climate, cells, progress, incision).network


def solve_streams(
    params: TerrainParams,
    climate: ClimateParams,
    cells: int = CELLS,
    progress: Callable[[float], None] | None = None,
    incision: float = INCISION,
) -> Solution:
    """As `solve`, with the cells of its streams and lakes and their valleys."""
    grid = cell_grid(across_of(cells))
    told = progress or (lambda share: None)
    params = uncarved(params)
    broad = replace(params, layers=min(params.layers, _LAYERS))
    heights = _heights(grid, broad, lambda share: told(0.35 * share))
    land = np.flatnonzero(heights > 0.0).astype(np.int32)
    if not 0 < len(land) < grid.count:
        raise ValueError("drainage: all ground lies above height 0, or below: there is no land whose water has an end")
    coarse = cell_grid(ACROSS)
    rain = rain_of(params, climate)
    told(0.4)
    around = grid.neighbours(land)
    around = around[around != NO_CELL]
    kept = np.union1d(land, around[heights[around] <= 0.0]).astype(np.int32)
    index = np.full(grid.count, -1, dtype=np.int64)
    index[kept] = np.arange(len(kept))
    neighbours = grid.neighbours(kept).astype(np.int64)
    neighbours = np.where(neighbours == NO_CELL, -1, index[neighbours])
    directions, height_m = grid.directions(kept), heights[kept]
    falls = np.maximum(coarse.interpolated(rain, directions), 0.0)
    # Whole millimetres: what is kept on disk gives the same rivers.
    runs = np.rint(np.minimum(runoff_mm(falls, temperature_c(directions, height_m, climate)), 65535.0))
    sea = height_m <= 0.0
    told(0.45)
    distance_m = _distances(directions, neighbours) * params.radius_m
    low = _LowGround(grid, broad, kept, np.maximum(height_m, 0.0))
    area_m2 = grid.areas(directions) * (params.radius_m * params.radius_m)
    flow = flow_of(height_m, sea, neighbours, distance_m)
    told(0.5)
    low.look(_with_catchment(grid, params.radius_m, add_downstream(flow, np.where(sea, 0.0, area_m2)), sea))
    told(0.7)
    # Distances are those of the places: ways between middles would prefer the lattice's directions.
    distance_m = _distances(low.places(directions), neighbours) * params.radius_m
    ground = CellGround(low.low_m, sea, neighbours, distance_m, area_m2, runs * 1e-3)
    carved = carve(ground, incision)
    told(0.95)
    # Where water has found another way meanwhile.
    catchment = add_downstream(carved.flow, np.where(sea, 0.0, area_m2))
    low.look(_with_catchment(grid, params.radius_m, catchment, sea) & ~carved.lake)
    carved = lowered(carved, low.low_m)
    offset = place_offsets(kept, low.place)
    rough = Network(grid, params.radius_m, kept, carved.flow.receiver, offset, runs)
    network = replace(rough, offset=_rounded(rough, _with_catchment(grid, params.radius_m, catchment, sea)))
    streams = stream_cells(network, carved, ground, low.relief_m, model_of(params))
    log.info(
        "%d cells of land, %d of a stream, %d of lakes, %d steps from the sea",
        len(land), len(streams.cells), int(carved.lake.sum()), len(flow.starts) - 2,
    )  # fmt: skip
    told(1.0)
    # Where no stream is nothing has been looked for; what is read from a file knows no more.
    plain = place_offsets(kept, 0)
    plain[np.searchsorted(kept, streams.cells)] = streams.offset
    return Solution(replace(network, offset=plain), streams)


def _rounded(network: Network, wanted: NDArray[np.bool_]) -> NDArray[np.int8]:
    """Offsets (N, 2) with the corners of the ways through the cells (N,) wanted rounded."""
    main, receiver = network.main, network.receiver
    cells = np.flatnonzero(wanted & (main >= 0))
    places, offset = network.places, network.offset.copy()
    offset[cells] = smoothed(
        network.grid, network.cells[cells], places[cells], places[main[cells]], places[receiver[cells]]
    )
    return offset


def uncarved(params: TerrainParams) -> TerrainParams:
    """The ground on which rivers find their way: without what they make of it, and without gullies, which lie between
    its cells."""
    return replace(
        params,
        rivers=None,
        water=None,
        woods=None,
        erosion=0.0,
        colored=False,
        layers=min(params.layers, _GROUND_LAYERS),
    )


def across_of(cells: int) -> int:
    """Cells along a face's edge, for about so many on the sphere."""
    return max(_LEAST_ACROSS, round((cells / 6.0) ** 0.5))


def rain_of(params: TerrainParams, climate: ClimateParams) -> Floats:
    """Rain of a year in mm on the cells on which air moves."""
    coarse = cell_grid(ACROSS)
    broad = replace(uncarved(params), layers=min(params.layers, _AIR_LAYERS))
    return rain_mm(coarse, _heights(coarse, broad), climate)


def _with_catchment(grid: CellGrid, radius_m: float, catchment_m2: Floats, sea: NDArray[np.bool_]) -> NDArray[np.bool_]:
    mean_m2 = 4.0 * np.pi * radius_m * radius_m / grid.count
    return ~sea & (catchment_m2 >= _SAMPLED_CELLS * mean_m2)


class _LowGround:
    """The lowest of the places in each cell, (N,): of those that have been looked at."""

    def __init__(self, grid: CellGrid, params: TerrainParams, cells: NDArray[np.int32], height_m: Floats) -> None:
        self._grid, self._params, self._cells = grid, params, cells
        self._seen = np.zeros(len(cells), dtype=bool)
        self.low_m = height_m.copy()
        self.place = np.zeros(len(cells), dtype=np.uint8)
        self.relief_m = np.zeros(len(cells))
        """by how far the lowest place lies below the mean"""

    def places(self, middles: Floats) -> Floats:
        """Unit directions (N, 3) of the lowest places; the cells' middles where nobody has looked."""
        found = middles.copy()
        found[self._seen] = place_directions(self._grid, self._cells[self._seen], self.place[self._seen])
        return found

    def look(self, wanted: NDArray[np.bool_]) -> None:
        """At the places of the cells (N,) wanted, where that has not been done. Places in the sea are left out."""
        found = np.flatnonzero(wanted & ~self._seen)
        if not len(found):
            return
        cells = self._cells[found]
        lowest, total = self.low_m[found], np.zeros(len(found))
        chosen = np.zeros(len(found), dtype=np.uint8)
        middle = lowest.copy()
        lowest = np.full(len(found), np.inf)
        for place in range(PLACES):
            here = _in_blocks(lambda part, k=place: place_directions(self._grid, part, k), cells, self._params)
            total += np.maximum(here, 0.0)
            lower = (here > 0.0) & (here < lowest)
            lowest, chosen = np.where(lower, here, lowest), np.where(lower, np.uint8(place), chosen)
        lowest = np.minimum(lowest, middle)
        self.relief_m[found] = np.maximum(total * (1.0 / PLACES) - lowest, 0.0)
        self.low_m[found] = np.maximum(lowest - FINER * self.relief_m[found], FINER * lowest)
        self.place[found] = chosen
        self._seen[found] = True


def _heights(grid: CellGrid, params: TerrainParams, told: Callable[[float], None] | None = None) -> Floats:
    """Of all cells."""
    return _in_blocks(grid.directions, np.arange(grid.count, dtype=np.int32), params, told)


def _in_blocks(
    directions: Callable[[NDArray[np.int32]], Floats],
    cells: NDArray[np.int32],
    params: TerrainParams,
    told: Callable[[float], None] | None = None,
) -> Floats:
    """Heights (N,) in the cells' directions, on all processors: numpy lets others work meanwhile."""
    edges = [*range(0, len(cells), _BLOCK), len(cells)]

    def part(bounds: tuple[int, int]) -> Floats:
        return height(directions(cells[slice(*bounds)]), params)

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
