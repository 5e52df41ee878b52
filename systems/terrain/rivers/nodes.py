"""River nodes: what carves the ground and holds the water, a node for each place where a river or a lake passes.

Nodes come from the planet's streams (drainage/), the same to the bit whether these were just solved or read from a
file. Lengths of valleys go with the planet's size in steps of two, as the ground's own do; widths of water do not.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....engine.table_cache import TableCache
from ..drainage.cells import NO_CELL, CellGrid
from ..drainage.climate import ClimateParams
from ..drainage.network import CELLS
from ..drainage.places import place_directions
from ..drainage.stored import streams_of
from ..drainage.streams import FLAT_SHARE, LEVEL_M, REACH_M, StreamCells, mouth_directions, unpacked_discharge
from ..height_params import TerrainParams

__all__ = ["RiverNodes", "nodes_of", "rivers_of_ground"]

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Indices = NDArray[np.int64]

WIDTH_BY_ROOT = 7.2
"""Metres of width by the root of m^3/s, and 0.27 Q^0.39 of depth: hydraulic geometry downstream (Leopold and Maddock
1953; the numbers are those of Moody and Troutman 2002 for rivers of all sizes)."""
_LEAST_M3_S = 1.0
"""Below this the valley is dry."""
_BANKS = 1.25
"""Least half width of a valley's floor, in half widths of its river."""
_LAKE_MIDDLE, _LAKE_RIM = 0.55, 0.3
"""Half widths of lakes, in cells: where water lies all around, and where it lies nowhere around."""
_FURTHEST_EDGE = 0.6
"""A river's node is no nearer to the edge of a lake than this share of its way from the lake's leaves."""
_LAKE_SHORE_M = 3000.0
"""From a lake's edge to where the ground is as it was, on a planet of Earth's size."""


@dataclass(frozen=True, eq=False)
class RiverNodes:
    """Arrays (N,). A node and its `to` make a segment, a straight line along which everything is linear."""

    direction: Floats
    """(N, 3) unit"""
    to: NDArray[np.int32]
    """the node downstream; -1: none, a mouth"""
    level_m: Singles
    """of the water above the reference sphere, from 0 up, never below that of `to`"""
    half_width_m: Singles
    """of the water; 0: a valley without"""
    depth_m: Singles
    """in the middle"""
    flat_m: Singles
    """half width of the valley's flat floor, at least that of the water"""
    reach_m: Singles
    """distance from the line at which the valley ends, more than flat_m"""
    lake: NDArray[np.bool_]
    """a lake's; a segment is a lake where both ends are, and then both have the same level"""
    discharge_m3_s: Singles

    def __len__(self) -> int:
        return len(self.to)


def rivers_of_ground(
    params: TerrainParams,
    climate: ClimateParams,
    cells: int = CELLS,
    strength: float = 1.0,
    progress: Callable[[float], None] | None = None,
    cache: TableCache | None = None,
) -> RiverNodes | None:
    """Rivers and lakes of a ground: shipped with the package, from the user's cache folder, or solved.

    cells: of the whole planet. strength: multiplies the water of all rivers, from 0, which gives None and solves
    nothing. progress(share) follows. ValueError for ground without land, or without any below height 0.
    """
    if not strength > 0.0:
        return None
    grid, streams = streams_of(params, climate, cells, progress, cache)
    return nodes_of(grid, streams, params, strength)


def nodes_of(grid: CellGrid, streams: StreamCells, params: TerrainParams, strength: float = 1.0) -> RiverNodes:
    """The nodes of streams: the cells' in their order, then the mouths, then those at the edges of lakes."""
    here, to, sea = _ways(grid, streams)
    rivers = _river_forms(streams, params, strength)
    lake = streams.lake > 0
    lakes = _lake_forms(grid, streams, params, rivers)

    mouth = np.flatnonzero(streams.mouth)
    shore = mouth_directions(here[mouth], sea, streams.mouth[mouth].astype(np.float64))
    shore_forms = rivers[:, mouth].copy()
    shore_forms[_LEVEL] = 0.0
    to[mouth] = len(to) + np.arange(len(mouth))

    # Where a river comes to a lake or leaves it.
    inland = np.flatnonzero(to < len(here))
    edge = inland[lake[inland] != lake[to[inland]]]
    below = to[edge]
    wet_end, dry_end = np.where(lake[edge], edge, below), np.where(lake[edge], below, edge)
    length_m = _lengths(here[edge] - here[below]) * params.radius_m
    share = np.minimum(lakes[_HALF_WIDTH, wet_end] / length_m, _FURTHEST_EDGE)
    edge_forms = rivers[:, dry_end].copy()
    edge_forms[_LEVEL] = lakes[_LEVEL, wet_end]
    between = _unit(here[wet_end] + (here[dry_end] - here[wet_end]) * share[:, None])
    to[edge] = len(to) + len(mouth) + np.arange(len(edge))

    forms = np.concatenate([np.where(lake, lakes, rivers), shore_forms, edge_forms], axis=1).astype(np.float32)
    level, half_width, depth, flat, reach, discharge = forms
    return RiverNodes(
        np.concatenate([here, shore, between]),
        np.concatenate([to, np.full(len(mouth), -1), below]).astype(np.int32),
        level,
        half_width,
        depth,
        flat,
        reach,
        np.concatenate([lake, np.zeros(len(mouth), dtype=bool), np.ones(len(edge), dtype=bool)]),
        discharge,
    )


_LEVEL, _HALF_WIDTH, _DEPTH, _FLAT, _REACH, _DISCHARGE = range(6)
"""Rows of forms (6, N): what is linear along a segment."""


def _ways(grid: CellGrid, streams: StreamCells) -> tuple[Floats, Indices, Floats]:
    """Places (N, 3) of the streams' nodes, indices (N,) of those downstream, and the sea's middles beyond the mouths."""
    around = grid.neighbours(streams.cells)
    to_cell = np.take_along_axis(around, streams.step[:, None].astype(np.int64), axis=1)[:, 0]
    to = np.searchsorted(streams.cells, to_cell).astype(np.int64)
    return (
        place_directions(grid, streams.cells, streams.place),
        to,
        grid.directions(to_cell[streams.mouth > 0]),
    )


def _river_forms(streams: StreamCells, params: TerrainParams, strength: float) -> Floats:
    """(6, N), as if there were no lakes."""
    discharge = unpacked_discharge(streams.discharge).astype(np.float64) * strength
    wet = discharge >= _LEAST_M3_S
    half_width = np.where(wet, 0.5 * WIDTH_BY_ROOT * np.sqrt(discharge), 0.0)
    depth = np.where(wet, _depth_m(discharge), 0.0)
    reach = streams.reach * (REACH_M * params.scale)
    flat = np.maximum(streams.flat * (FLAT_SHARE / 255.0) * reach, _BANKS * half_width)
    reach = np.maximum(reach, flat * (1.0 / FLAT_SHARE))
    return np.stack([streams.level * LEVEL_M, half_width, depth, flat, reach, discharge])


def _lake_forms(grid: CellGrid, streams: StreamCells, params: TerrainParams, rivers: Floats) -> Floats:
    """(6, N), as if all were lakes: as wide as there is water in the cells around."""
    forms = rivers.copy()
    cells = np.flatnonzero(streams.lake)
    beside = grid.neighbours(streams.cells[cells])[:, :4]
    water = np.zeros(grid.count, dtype=bool)
    water[streams.cells[cells]] = True
    share = 0.25 * (water[beside] & (beside != NO_CELL)).sum(axis=1)
    cell_m = params.radius_m * np.sqrt(4.0 * np.pi / grid.count)
    half_width = (_LAKE_RIM + (_LAKE_MIDDLE - _LAKE_RIM) * share) * cell_m
    forms[_HALF_WIDTH, cells] = half_width
    forms[_DEPTH, cells] = np.maximum(streams.lake[cells] * LEVEL_M, rivers[_DEPTH, cells])
    forms[_FLAT, cells] = half_width
    forms[_REACH, cells] = half_width + _LAKE_SHORE_M * params.scale
    return forms


def _depth_m(discharge: Floats) -> Floats:
    """0.27 Q^(25/64), from roots alone: every machine rounds those alike."""
    fourth = np.sqrt(np.sqrt(discharge))
    eighth = np.sqrt(fourth)
    return 0.27 * fourth * eighth * np.sqrt(np.sqrt(np.sqrt(eighth)))


def _lengths(vectors: Floats) -> Floats:
    x, y, z = vectors.T
    return np.sqrt(x * x + y * y + z * z)


def _unit(vectors: Floats) -> Floats:
    return vectors / _lengths(vectors)[:, None]
