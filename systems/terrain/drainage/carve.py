"""Levels of the rivers: ground lowered along the ways of its water until none climbs.

The ground of cells is cut by the stream power law, dz/dt = -K sqrt(A) dz/dx with A the catchment by its water, in a few
implicit steps from the sea up (Braun and Willett 2013): valleys become concave, and steep reaches move upstream the
further the more water they have. Between the steps the ways are found anew, so that water follows the valleys that it
has cut.
Hollows that hold a lake keep it, at the level of their pass; passes of the others are cut down to their floors.
Operations are + - x / sqrt alone, as in `routing`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .routing import Flow, add_downstream, flow_of

__all__ = ["INCISION", "LAKE_EVAPORATES_M_YEAR", "Carved", "CellGround", "carve", "lowered"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Flags = NDArray[np.bool_]

INCISION = 1.25
"""How far rivers have cut, K times the time: steep reaches have come so many roots of their catchment upstream."""
_MEAN_RUNOFF_M, _DRY, _WETTEST = 0.36, 0.25, 2.0
"""Runoff of a year where all land of a catchment counts; how much that counts which has none, cut by rare floods, and
that which has most."""
_STEPS = 3
_DEEPEST_M = 1500.0
"""Below the cells' low ground; only passes that would hold water back are cut further."""
_LAKE_DEPTH_M, _LAKE_CELLS = 60.0, 300
LAKE_EVAPORATES_M_YEAR = 1.0
"""Water that a lake loses to the air and that has to come in (Penman's estimates run from 0.6 in the cold to 2)."""


@dataclass(frozen=True, eq=False)
class CellGround:
    """What is carved: cells (N,), of which those of the sea end all ways."""

    low_m: Floats
    """low ground in each, where its river would run"""
    sea: Flags
    neighbours: Indices
    """(N, 8), -1: none"""
    distance_m: Floats
    """(N, 8) to them, above 0 even where there is none"""
    area_m2: Floats
    water_m: Floats
    """that runs off in a year"""


@dataclass(frozen=True, eq=False)
class Carved:
    """Levels (N,) of the water of cells, never below those downstream."""

    flow: Flow
    level_m: Floats
    """0 in the sea"""
    lake: Flags
    floor_m: Floats
    """ground of the lakes' cells; of others the level"""


def carve(ground: CellGround, incision: float = INCISION) -> Carved:
    """The levels of `ground`'s rivers; incision 0 only cuts through passes."""
    floor = np.where(ground.sea, np.minimum(ground.low_m, 0.0), np.maximum(ground.low_m, 0.0))
    deepest = floor - _DEEPEST_M
    for _ in range(_STEPS if incision > 0.0 else 0):
        flow = flow_of(floor, ground.sea, ground.neighbours, ground.distance_m)
        held, lake = _held(ground, flow, floor)
        apart = _apart(ground, flow)
        catchment = add_downstream(flow, np.where(ground.sea, 0.0, ground.area_m2 * _wetness(ground.water_m)))
        factor = incision / _STEPS * np.sqrt(catchment) / apart
        level = _incised(flow, held, lake, factor, np.minimum(held, deepest))
        floor = np.where(lake, np.minimum(floor, level), level)
    flow = flow_of(floor, ground.sea, ground.neighbours, ground.distance_m)
    level, lake = _held(ground, flow, floor)
    return Carved(flow, level, lake, np.where(lake, floor, level))


def _wetness(water_m: Floats) -> Floats:
    """What land counts for in a catchment, by the water that runs off it in a year: 1 for Earth's mean."""
    return _DRY + (1.0 - _DRY) * np.minimum(water_m * (1.0 / _MEAN_RUNOFF_M), _WETTEST)


def _apart(ground: CellGround, flow: Flow) -> Floats:
    """Metres (N,) to each cell's receiver, 1 in the sea."""
    found = np.ones(len(flow.receiver))
    for k in range(ground.neighbours.shape[1]):
        found = np.where(ground.neighbours[:, k] == flow.receiver, ground.distance_m[:, k], found)
    return found


def _levels(flow: Flow) -> list[Indices]:
    """Cells by steps from the sea, from 1 up."""
    return [flow.order[a:b] for a, b in zip(flow.starts[1:-1], flow.starts[2:], strict=True)]


def _held(ground: CellGround, flow: Flow, floor: Floats) -> tuple[Floats, Flags]:
    """Levels (N,) with lakes filled to their passes and every other pass cut to what it holds back; and which cells
    are a lake's."""
    levels = _levels(flow)
    filled = np.where(ground.sea, 0.0, floor)
    for cells in levels:
        filled[cells] = np.maximum(filled[cells], filled[flow.receiver[cells]])
    lake = _lakes(ground, flow, floor, filled)
    # Upstream of a lake nothing is cut below it.
    base = np.where(lake, filled, 0.0)
    for cells in levels:
        base[cells] = np.maximum(base[cells], base[flow.receiver[cells]])
    level = np.maximum(np.where(ground.sea, 0.0, floor), base)
    for cells in levels[::-1]:
        np.minimum.at(level, flow.receiver[cells], level[cells])
    return level, lake


def _lakes(ground: CellGround, flow: Flow, floor: Floats, filled: Floats) -> Flags:
    """Flooded cells (N,) of hollows that are deep enough, not an inland sea, and get more water than dries up."""
    flooded = filled > floor
    outlet = np.where(flooded, flow.receiver, np.arange(len(floor)))
    while True:
        further = outlet[outlet]
        if np.array_equal(further, outlet):
            break
        outlet = further
    deepest, count = np.zeros(len(floor)), np.zeros(len(floor), dtype=np.int64)
    cells = np.flatnonzero(flooded)
    np.maximum.at(deepest, outlet[cells], filled[cells] - floor[cells])
    np.add.at(count, outlet[cells], 1)
    surface = np.zeros(len(floor))
    np.add.at(surface, outlet[cells], ground.area_m2[cells])
    comes = add_downstream(flow, np.where(ground.sea, 0.0, ground.area_m2 * ground.water_m))
    worth = (deepest >= _LAKE_DEPTH_M) & (count <= _LAKE_CELLS) & (comes >= LAKE_EVAPORATES_M_YEAR * surface)
    return flooded & worth[outlet]


def _incised(flow: Flow, held: Floats, lake: Flags, factor: Floats, least: Floats) -> Floats:
    """One implicit step of the stream power law; a lake is as high as its outlet."""
    level = held.copy()
    for cells in _levels(flow):
        below, here = level[flow.receiver[cells]], level[cells]
        cut = np.maximum((here + factor[cells] * below) / (1.0 + factor[cells]), least[cells])
        level[cells] = np.where(lake[cells], below, cut)
    return level


def lowered(carved: Carved, low_m: Floats) -> Carved:
    """The same with no river above low ground (N,), known better meanwhile; lakes stay."""
    flow, levels = carved.flow, _levels(carved.flow)
    base = np.where(carved.lake, carved.level_m, 0.0)
    for cells in levels:
        base[cells] = np.maximum(base[cells], base[flow.receiver[cells]])
    level = np.maximum(np.where(carved.lake, carved.level_m, np.minimum(carved.level_m, low_m)), base)
    for cells in levels[::-1]:
        np.minimum.at(level, flow.receiver[cells], level[cells])
    return Carved(flow, level, carved.lake, np.where(carved.lake, carved.floor_m, level))
