"""Rivers that have been solved before, from the user's cache folder."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ....engine.table_cache import TableCache
from ..height_params import TerrainParams
from .cells import CellGrid, cell_grid
from .climate import ClimateParams
from .network import CELLS, Network
from .solve import Solution, across_of, solve_streams
from .streams import StreamCells

__all__ = ["network_of", "streams_of"]

_VERSION = "2"
"""Part of the keys: change it with what this folder computes."""
_SHORE, _OPEN_SEA = 8, 255
"""In place of the number of the neighbour that a cell's water goes to."""
_PLACE = 16
"""A cell's place, times this, is added to that number."""


def _key(params: TerrainParams, climate: ClimateParams, cells: int) -> str:
    """One name for all that a planet's rivers depend on."""
    map_ = params.height_map
    content = "" if map_ is None else hashlib.sha256(map_.cube.levels[0].tobytes()).hexdigest()
    ground = repr(replace(params, height_map=None))
    return TableCache.key(_VERSION, str(across_of(cells)), ground, content, repr(climate))


def network_of(
    params: TerrainParams,
    climate: ClimateParams,
    cells: int = CELLS,
    progress: Callable[[float], None] | None = None,
    cache: TableCache | None = None,
) -> Network:
    """As `solve`, from the user's cache folder where it has been solved before."""
    cache = TableCache("drainage") if cache is None else cache
    grid, key = cell_grid(across_of(cells)), _key(params, climate, cells)
    held = cache.load(key, {"step": (grid.count,), "runoff_mm": (grid.count,)}, np.uint16)
    if held is not None:
        if progress is not None:
            progress(1.0)
        return _unpacked(grid, params.radius_m, held["step"], held["runoff_mm"])
    made = solve_streams(params, climate, cells, progress)
    keep(cache, key, made)
    return made.network


def streams_of(
    params: TerrainParams,
    climate: ClimateParams,
    cells: int = CELLS,
    progress: Callable[[float], None] | None = None,
    cache: TableCache | None = None,
) -> tuple[CellGrid, StreamCells]:
    """The cells with streams, and the grid that they are of; solved where nobody has done so before."""
    return cell_grid(across_of(cells)), solve_streams(params, climate, cells, progress).streams


def keep(cache: TableCache, key: str, made: Solution) -> None:
    """Write a network down."""
    network = made.network
    count = network.grid.count
    step, runoff = np.full(count, _OPEN_SEA, dtype=np.uint8), np.zeros(count, dtype=np.uint16)
    step[network.cells] = _steps(network) + _PLACE * network.place
    runoff[network.cells] = network.runoff_mm
    cache.save(key, {"step": step, "runoff_mm": runoff})


def _steps(network: Network) -> NDArray[np.uint8]:
    neighbours = network.grid.neighbours(network.cells)
    to = network.cells[network.receiver]
    step = np.argmax(neighbours == to[:, None], axis=1)
    return np.where(network.sea, _SHORE, step).astype(np.uint8)


def _unpacked(grid: CellGrid, radius_m: float, packed: NDArray[np.uint16], runoff: NDArray[np.uint16]) -> Network:
    cells = np.flatnonzero(packed < _OPEN_SEA).astype(np.int32)
    place, step = np.divmod(packed[cells], _PLACE)
    neighbours = grid.neighbours(cells)
    number = np.concatenate([neighbours, cells[:, None]], axis=1)[np.arange(len(cells)), step]
    to = np.searchsorted(cells, number)
    return Network(grid, radius_m, cells, to, place.astype(np.uint8), runoff[cells].astype(np.float64))
