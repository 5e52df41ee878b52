"""Rivers that have been solved before: shipped with the package, or from the user's cache folder.

One file holds a planet's whole network and its streams (3 MB for Earth).
"""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ....engine.table_cache import TableCache
from ..height_params import TerrainParams
from .carve import INCISION
from .cells import CellGrid, cell_grid
from .climate import ACROSS, ClimateParams
from .network import CELLS, Network
from .packing import pack, unpack
from .places import place_offsets
from .solve import Solution, across_of, rain_of, solve_streams, uncarved
from .streams import StreamCells

__all__ = ["SHIPPED", "key_of", "network_of", "rain_grid_of", "ship", "streams_of"]

log = logging.getLogger(__name__)

Floats = NDArray[np.float64]

_VERSION = "3"
"""Part of the keys: change it with what this folder computes."""
_SHORE, _STREAM = 8, 16
"""In place of the number of the neighbour that a cell's water goes to, and added to it where there is a stream."""
_LAND = {"gap": np.uint32, "way": np.uint8, "runoff": np.uint16}
"""Of cells of land and shore: the number less that of the one before, the way as above, and mm, changes from cell to
cell as well."""
_STREAMS = {
    "i": np.int8, "j": np.int8, "level": np.uint16, "discharge": np.uint16, "flat": np.uint8, "reach": np.uint8,
    "lake": np.uint16, "mouth": np.uint8,
}  # fmt: skip
"""Of cells with streams: the offset, and the rest of StreamCells."""

# The assets lie beside `systems`, in a checkout as in an installed package.
SHIPPED = TableCache("rivers", Path(__file__).parents[3] / "assets")
"""What is part of the package: the rivers of the preset earth."""


@dataclass(frozen=True, eq=False)
class _Kept:
    """The columns of a file."""

    land: dict[str, NDArray[np.integer]]
    streams: dict[str, NDArray[np.integer]]

    @property
    def cells(self) -> NDArray[np.int32]:
        """Of the land and its shore."""
        return np.cumsum(self.land["gap"], dtype=np.int64).astype(np.int32)

    @property
    def stream(self) -> NDArray[np.bool_]:
        """Which of these have a stream."""
        return self.land["way"] >= _STREAM

    @property
    def step(self) -> NDArray[np.uint8]:
        """Where water goes from these."""
        return self.land["way"].astype(np.uint8) & np.uint8(_STREAM - 1)

    @property
    def offset(self) -> NDArray[np.int8]:
        """(M, 2) of the streams."""
        return np.stack([self.streams["i"], self.streams["j"]], axis=1).astype(np.int8)


def network_of(
    params: TerrainParams,
    climate: ClimateParams,
    cells: int = CELLS,
    progress: Callable[[float], None] | None = None,
    cache: TableCache | None = None,
    incision: float = INCISION,
) -> Network:
    """As `solve`, from a file where it has been solved before. cache: the folder, instead of the package's and the
    user's."""
    key = key_of(params, climate, across_of(cells), incision)
    kept = _load(key, cache)
    if kept is None:
        return _keep_in(cache, key, solve_streams(params, climate, cells, progress, incision)).network
    _told(progress)
    grid, numbers = cell_grid(across_of(cells)), kept.cells
    ways = np.concatenate([grid.neighbours(numbers), numbers[:, None]], axis=1)
    to = np.searchsorted(numbers, ways[np.arange(len(numbers)), kept.step])
    offset = place_offsets(numbers, 0)
    offset[kept.stream] = kept.offset
    runoff = np.cumsum(kept.land["runoff"].astype(np.uint16), dtype=np.uint16).astype(np.float64)
    return Network(grid, params.radius_m, numbers, to, offset, runoff)


def streams_of(
    params: TerrainParams,
    climate: ClimateParams,
    cells: int = CELLS,
    progress: Callable[[float], None] | None = None,
    cache: TableCache | None = None,
    incision: float = INCISION,
) -> tuple[CellGrid, StreamCells]:
    """The cells with streams, and the grid that they are of; otherwise as `network_of`."""
    grid, key = cell_grid(across_of(cells)), key_of(params, climate, across_of(cells), incision)
    kept = _load(key, cache)
    if kept is None:
        return grid, _keep_in(cache, key, solve_streams(params, climate, cells, progress, incision)).streams
    _told(progress)
    numbers, step, found = kept.cells[kept.stream], kept.step[kept.stream], kept.streams
    return grid, StreamCells(
        numbers,
        step,
        kept.offset,
        level=found["level"].astype(np.uint16),
        discharge=found["discharge"].astype(np.uint16),
        flat=found["flat"].astype(np.uint8),
        reach=found["reach"].astype(np.uint8),
        lake=found["lake"].astype(np.uint16),
        mouth=found["mouth"].astype(np.uint8),
    )


def rain_grid_of(params: TerrainParams, climate: ClimateParams, cache: TableCache | None = None) -> Floats:
    """Rain of a year in mm on the cells on which air moves, in whole numbers."""
    cache = TableCache("drainage") if cache is None else cache
    count, key = cell_grid(ACROSS).count, TableCache.key("rain", key_of(params, climate, ACROSS))
    held = cache.load(key, {"rain_mm": (count,)}, np.uint16)
    if held is not None:
        return held["rain_mm"].astype(np.float64)
    found = np.rint(np.minimum(rain_of(params, climate), 65535.0))
    cache.save(key, {"rain_mm": found.astype(np.uint16)})
    return found


def ship(params: TerrainParams, climate: ClimateParams, cells: int = CELLS) -> Path:
    """Solve and write a file among the package's assets: for who changes what rivers depend on."""
    key = key_of(params, climate, across_of(cells))
    _keep(SHIPPED, key, solve_streams(params, climate, cells))
    assert SHIPPED.folder is not None
    return SHIPPED.folder / f"{key}.npz"


def key_of(params: TerrainParams, climate: ClimateParams, across: int, incision: float = INCISION) -> str:
    """One name for all that a planet's rivers depend on."""
    map_ = params.height_map
    content = "" if map_ is None else hashlib.sha256(map_.cube.levels[0].tobytes()).hexdigest()
    ground = replace(uncarved(params), height_map=None)
    # Of the params those that differ from the defaults: a new knob that nobody uses changes no planet's rivers.
    given = [(f.name, getattr(ground, f.name)) for f in fields(ground) if getattr(ground, f.name) != f.default]
    cut = () if incision == INCISION else (repr(incision),)
    return TableCache.key(_VERSION, str(across), repr(given), content, repr(climate), *cut)


def _keep_in(cache: TableCache | None, key: str, made: Solution) -> Solution:
    _keep(TableCache("drainage") if cache is None else cache, key, made)
    return made


def _told(progress: Callable[[float], None] | None) -> None:
    if progress is not None:
        progress(1.0)


def _keep(cache: TableCache, key: str, made: Solution) -> None:
    network, streams = made.network, made.streams
    neighbours = network.grid.neighbours(network.cells)
    step = np.argmax(neighbours == network.cells[network.receiver][:, None], axis=1)
    way = np.where(network.sea, _SHORE, step).astype(np.uint8)
    way[np.searchsorted(network.cells, streams.cells)] += np.uint8(_STREAM)
    gap = np.diff(network.cells, prepend=np.int32(0)).astype(np.uint32)
    runoff = np.diff(network.runoff_mm.astype(np.uint16), prepend=np.uint16(0))  # modulo 2^16
    land = pack([gap, way, runoff])
    i, j = streams.offset.T
    columns = [i, j, streams.level, streams.discharge, streams.flat, streams.reach, streams.lake, streams.mouth]
    found = pack(columns)
    sizes = {"land_size": np.array(len(land)), "stream_size": np.array(len(found))}
    cache.save(key, {**sizes, "land": land, "streams": found})


def _load(key: str, cache: TableCache | None) -> _Kept | None:
    """The file of a ground: of the package, or of the user."""
    for place in (SHIPPED, TableCache("drainage")) if cache is None else (cache,):
        sizes = place.load(key, {"land_size": (), "stream_size": ()}, np.int64)
        if sizes is None:
            continue
        shapes = {"land": (int(sizes["land_size"]),), "streams": (int(sizes["stream_size"]),)}
        held = place.load(key, shapes, np.uint8)
        if held is None:
            continue
        try:
            return _Kept(unpack(held["land"], _LAND), unpack(held["streams"], _STREAMS))
        except ValueError as error:
            log.warning("rivers in %s cannot be used and are solved again: %s", place.folder, error)
    return None
