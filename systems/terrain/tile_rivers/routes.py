"""Where water of a grid's cells goes, how much comes together, and which hollows and flat places are lakes.

Ways are those of the planet's own rivers (drainage/routing.py): down the steepest slope, out of hollows over the lowest
pass as if water had cut it, and at the data's border out of it. A lake's cells are then let down to its outlet, and
ways found anew.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..drainage.carve import LAKE_EVAPORATES_M_YEAR
from ..drainage.routing import Flow, add_downstream, flow_of
from .cells import AROUND, GridCells, Indices, regions

__all__ = ["Lake", "LakeRules", "Routes", "routes_of"]

Floats = NDArray[np.float64]

_LEAST_CELLS = 16
"""Of a lake: less is noise."""
_LOW_RIM = 0.03
"""Share of a flat place's rim that may lie below it: more is a step of whole metres on a slope."""
_STEP_M = 1e-6
"""By which cells of a lake are let down on the way to its outlet."""


@dataclass(frozen=True)
class LakeRules:
    """What a lake is: least area, and least depth of a hollow that holds one."""

    area_m2: float
    depth_m: float


@dataclass(frozen=True, eq=False)
class Lake:
    """Cells (K,), and the one that its water leaves by. hollow: the files show its bed, not its surface."""

    cells: Indices
    outlet: int
    level_m: float
    hollow: bool


@dataclass(frozen=True, eq=False)
class Routes:
    """Of cells (N + 1,): where water goes, and what comes through each."""

    flow: Flow
    catchment_m2: Floats
    surface_m: Floats
    """of ground, and of lakes"""
    filled_m: Floats
    """as high as a flood from the sea and the border would stand"""
    cut: NDArray[np.bool_]
    """some of the catchment may lie beyond the data"""
    lakes: list[Lake]


def routes_of(cells: GridCells, runoff_m_year: float, lakes: LakeRules | None) -> Routes:
    """lakes: without rules there are none, and ways cut through all passes."""
    found = _routed(cells, cells.routed_m)
    if lakes is None:
        return found
    still = _lakes(cells, found, runoff_m_year, lakes)
    if not still:
        return found
    routed, surface = cells.routed_m.copy(), cells.height_m.copy()
    for lake in still:
        surface[lake.cells] = lake.level_m
        routed[lake.cells] = lake.level_m + _STEP_M * (1.0 + _steps(cells, lake))
    found = _routed(cells, routed)
    return replace(found, surface_m=surface, lakes=[replace(k, outlet=_outlet(found, k.cells)[0]) for k in still])


def _routed(cells: GridCells, height_m: Floats) -> Routes:
    flow = flow_of(height_m, cells.sea, cells.neighbours, cells.distance_m)
    catchment = add_downstream(flow, cells.area_m2)
    inwards = cells.border & (flow.receiver != cells.out)
    cut = add_downstream(flow, inwards.astype(np.float64)) > 0.0
    filled, to = height_m.copy(), flow.receiver
    while True:
        filled = np.maximum(filled, filled[to])
        further = to[to]
        if np.array_equal(further, to):
            break
        to = further
    return Routes(flow, catchment, cells.height_m, filled, cut, [])


def _lakes(cells: GridCells, routes: Routes, runoff_m_year: float, rules: LakeRules) -> list[Lake]:
    """Hollows, and flat places that are in none of them."""
    deep = routes.filled_m - cells.routed_m
    wet = (deep > 0.0) & ~cells.sea
    found = []
    for part in _parts(cells, regions(cells, wet, routes.filled_m), rules.area_m2):
        outlet, comes_m2 = _outlet(routes, part)
        enough = comes_m2 * runoff_m_year >= LAKE_EVAPORATES_M_YEAR * cells.area_m2[part].sum()
        if enough and deep[part].max() >= rules.depth_m:
            found.append(Lake(part, outlet, float(routes.filled_m[part[0]]), True))
    taken = np.zeros(len(wet), dtype=bool)
    for lake in found:
        taken[lake.cells] = True
    flat = _flat(cells) & ~taken
    for part in _parts(cells, regions(cells, flat, cells.height_m), rules.area_m2):
        if _is_level(cells, part):
            found.append(Lake(part, _outlet(routes, part)[0], float(cells.height_m[part[0]]), False))
    return sorted(found, key=lambda lake: int(lake.cells[0]))


def _flat(cells: GridCells) -> NDArray[np.bool_]:
    """Land with a neighbour of exactly its own height."""
    found = np.zeros(len(cells.sea), dtype=bool)
    for k in range(len(AROUND)):
        to = cells.neighbours[:, k]
        found |= (to >= 0) & (cells.height_m[to] == cells.height_m)
    return found & ~cells.sea


def _parts(cells: GridCells, label: Indices, area_m2: float) -> list[Indices]:
    """Cells of each region that is large enough, rising."""
    at = np.flatnonzero(label >= 0)
    if not at.size:
        return []
    at = at[np.argsort(label[at], kind="stable")]
    first = np.flatnonzero(np.append(True, label[at][1:] != label[at][:-1]))
    parts = np.split(at, first[1:])
    return [part for part in parts if len(part) >= _LEAST_CELLS and cells.area_m2[part].sum() >= area_m2]


def _outlet(routes: Routes, part: Indices) -> tuple[int, float]:
    """The cell that most water leaves a part by, and the land that it comes from."""
    leaves = part[~np.isin(routes.flow.receiver[part], part)]
    most = int(leaves[np.argmax(routes.catchment_m2[leaves])])
    return most, float(routes.catchment_m2[most])


def _is_level(cells: GridCells, part: Indices) -> bool:
    """Whether a flat place has higher ground nearly all around: a lake; a flat of whole metres goes on downhill."""
    around = np.unique(cells.neighbours[part, : len(AROUND)])
    rim = np.setdiff1d(around[around >= 0], part)
    lower = int((cells.height_m[rim] < cells.height_m[part[0]]).sum())
    return bool(len(rim)) and lower <= max(2.0, _LOW_RIM * len(rim))


def _steps(cells: GridCells, lake: Lake) -> Floats:
    """(K,) how far a lake's cells are from its outlet, in steps; rings of the same number one after the other."""
    inside = np.full(len(cells.sea), -1)
    inside[lake.cells] = np.arange(len(lake.cells))
    found = np.full(len(lake.cells), -1.0)
    front, step = np.array([lake.outlet]), 0.0
    while front.size:
        found[inside[front]] = step
        to = cells.neighbours[front, : len(AROUND)].ravel().astype(np.int64)
        to = to[to >= 0]
        to = np.unique(to[inside[to] >= 0])
        front, step = to[found[inside[to]] < 0.0], step + 1.0
    return found
