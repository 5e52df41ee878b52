"""River nodes: what carves the ground and holds the water, a node for each place where a river or a lake passes.

Nodes come from the planet's streams (drainage/), the same to the bit whether these were just solved or read from a
file. Lengths of valleys go with the planet's size in steps of two, as the ground's own do; widths of water do not.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ....engine.table_cache import TableCache
from ..drainage.carve import INCISION
from ..drainage.cells import CellGrid
from ..drainage.climate import ClimateParams
from ..drainage.network import CELLS
from ..drainage.places import offset_directions
from ..drainage.stored import SHIPPED, key_of, streams_of
from ..drainage.streams import StreamCells
from ..height_params import TerrainParams
from .bays import bays_of, find_bays, keep, with_bays
from .between import Course, confluences, estuaries, lake_edges, middles, mouths
from .falls import with_falls
from .node_arrays import RiverNodes
from .troughs import with_troughs
from .widths import ROWS, lake_rows, river_rows

__all__ = ["RiverNodes", "nodes_of", "rivers_of_ground", "ship_bays"]

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]


def rivers_of_ground(
    params: TerrainParams,
    climate: ClimateParams,
    cells: int = CELLS,
    strength: float = 1.0,
    progress: Callable[[float], None] | None = None,
    cache: TableCache | None = None,
    incision: float = INCISION,
) -> RiverNodes | None:
    """Rivers and lakes of a ground: shipped with the package, from the user's cache folder, or solved.

    cells: of the whole planet. strength: multiplies the water of all rivers, from 0, which gives None and solves
    nothing. incision: how far they have cut, see drainage/carve.py. progress(share) follows. ValueError for ground
    without land, or without any below height 0.
    """
    if not strength > 0.0:
        return None
    grid, streams = streams_of(params, climate, cells, progress, cache, incision)
    plain = nodes_of(grid, streams, params, strength)

    def full() -> RiverNodes:
        return plain if strength == 1.0 else nodes_of(grid, streams, params)

    key = key_of(params, climate, grid.across, incision)
    nodes = with_troughs(plain, climate, params.scale, strength)
    nodes = with_bays(nodes, bays_of(full, params, grid.count, key, cache))
    return with_falls(nodes, params.radius_m, strength)


def ship_bays(params: TerrainParams, climate: ClimateParams, cells: int = CELLS) -> None:
    """Find bays and write their file among the package's assets: after drainage/stored.py's `ship`."""
    grid, streams = streams_of(params, climate, cells)
    keep(SHIPPED, key_of(params, climate, grid.across), find_bays(nodes_of(grid, streams, params), params, grid.count))


def nodes_of(grid: CellGrid, streams: StreamCells, params: TerrainParams, strength: float = 1.0) -> RiverNodes:
    """The nodes of streams: the cells' in their order, then those between them."""
    rivers = river_rows(streams, params, strength)
    course = _course(grid, streams, params, rivers)
    main = course.main()
    joins = confluences(course, main)
    parts = (mouths(course), lake_edges(course), joins, middles(course, main, joins.upper))
    count, to, follows = len(course.to), course.to.copy(), [course.to]
    for part in parts:
        to[part.upper] = count + np.arange(len(part.upper))
        follows.append(course.to[part.upper])
        count += len(part.upper)
    follows[0] = to
    # Mouths, the first of these parts, go on below the sea.
    out = estuaries(course, params.scale)
    follows[1] = np.full(len(parts[0].upper), -1)
    follows[1][np.searchsorted(parts[0].upper, out.upper)] = count + np.arange(len(out.upper))
    follows.append(np.full(len(out.upper), -1))
    parts = (*parts, out)
    rows = [np.where(course.lake, course.lakes, rivers), *(part.rows for part in parts)]
    lake = [course.lake, *(np.full(len(part.upper), part.lake) for part in parts)]
    columns = dict(zip(ROWS, np.concatenate(rows, axis=1).astype(np.float32), strict=True))
    return RiverNodes(
        direction=np.concatenate([course.here, *(part.direction for part in parts)]),
        to=np.concatenate(follows).astype(np.int32),
        lake=np.concatenate(lake),
        **columns,
    )


def _course(grid: CellGrid, streams: StreamCells, params: TerrainParams, rivers: Floats) -> Course:
    around = grid.neighbours(streams.cells)
    to_cell = np.take_along_axis(around, streams.step[:, None].astype(np.int64), axis=1)[:, 0]
    ends = streams.mouth > 0
    return Course(
        grid,
        streams,
        params.radius_m,
        offset_directions(grid, streams.cells, streams.offset),
        np.where(ends, len(to_cell), np.searchsorted(streams.cells, to_cell)).astype(np.int64),
        grid.directions(to_cell[ends]),
        rivers,
        lake_rows(grid, streams, params, rivers),
    )
