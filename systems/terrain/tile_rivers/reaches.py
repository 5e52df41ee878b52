"""Streams along the ways of a grid's water: reaches from springs and confluences to the next, by rivers."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..drainage.routing import Flow
from .cells import GridCells, Indices
from .courses import curved, offsets_of
from .routes import Routes

__all__ = ["Reach", "reaches_of"]

Floats = NDArray[np.float64]

_GROWN = 1.5
"""A reach whose water has grown by that is two: each has one width."""


@dataclass(frozen=True, eq=False)
class Reach:
    """cells (K,) downstream; the last is where another reach begins, the sea's first or the data's last. river: from 1,
    the largest, up; into: the river that this one ends in, 0: none."""

    cells: Indices
    places: Floats
    """(M, 2) longitude and latitude, degrees, on a curve through them"""
    level_m: Floats
    """(M,) of the ground there, as low as anything upstream"""
    catchment_m2: float
    """at its lower end"""
    river: int
    into: int
    order: int
    """Strahler's"""
    cut: bool
    ends: str
    """"river", "sea" or "border": of the whole river"""


def reaches_of(cells: GridCells, routes: Routes, springs_m2: float) -> list[Reach]:
    """Of all ways with a catchment of springs_m2 or more, by river, downstream."""
    receiver, catchment = routes.flow.receiver, routes.catchment_m2
    stream = (catchment >= springs_m2) & ~cells.sea
    at = np.flatnonzero(stream)
    if not at.size:
        return []
    levels = _by_level(routes.flow, stream)
    level_m = _levels(routes, levels)
    come = np.bincount(receiver[at], minlength=len(receiver))
    main = _main(at, receiver, catchment)
    goes_on = np.where(stream & (main[receiver] == np.arange(len(receiver))) & stream[receiver], receiver, -1)
    last = _ends(goes_on)
    offset, runs = np.zeros((len(receiver), 2)), np.zeros((len(receiver), 2))
    offset[at], runs[at] = offsets_of(cells, routes.flow, main, at)
    ends = np.unique(last[at])
    ends = ends[np.lexsort((ends, -catchment[ends]))]
    name = np.zeros(len(receiver), dtype=np.int64)
    name[ends] = 1 + np.arange(len(ends))
    grid, found = cells.grid, []
    per_cell = np.array([grid.degree_steps[0], -grid.degree_steps[1]])
    for cell in at[come[at] != 1].tolist():
        way = _walk(cell, receiver, stream, come, cells)
        river = int(name[last[cell]])
        below = int(receiver[last[cell]])
        ends_in = "river" if stream[below] else "border" if below == cells.out else "sea"
        into = int(name[last[below]]) if stream[below] else 0
        for part in _parts(way, catchment, stream):
            if len(part) < 2:  # a confluence on the border
                continue
            lower = part[-1] if part[-1] == way[-1] and receiver[part[-1]] == cells.out else part[-2]
            curve, level = curved(cells.places(part, offset[part]), runs[part] * per_cell, level_m[part])
            cut = bool(routes.cut[lower])
            found.append(Reach(part, curve, level, float(catchment[lower]), river, into, 0, cut, ends_in))
    return _ordered(found, levels, receiver, stream)


def _by_level(flow: Flow, wanted: NDArray[np.bool_]) -> list[Indices]:
    """Cells that are wanted, those farthest from the ends of their ways first."""
    order = flow.order[wanted[flow.order]]
    step = np.searchsorted(flow.starts, np.flatnonzero(wanted[flow.order]), side="right")
    first = np.flatnonzero(np.append(True, step[1:] != step[:-1]))
    return np.split(order, first[1:])[::-1]


def _levels(routes: Routes, levels: list[Indices]) -> Floats:
    """Heights of ground and lakes, no higher than any upstream along streams."""
    found, receiver = routes.surface_m.copy(), routes.flow.receiver
    for part in levels:
        np.minimum.at(found, receiver[part], found[part])
    return found


def _main(at: Indices, receiver: Indices, catchment: Floats) -> Indices:
    """Of the streams that come to each cell the one with the largest catchment, the lower index of equals."""
    found = np.full(len(receiver), -1)
    by_land = at[np.lexsort((-at, catchment[at]))]
    found[receiver[by_land]] = by_land
    return found


def _ends(goes_on: Indices) -> Indices:
    """Where the way from each cell ends."""
    to = np.where(goes_on >= 0, goes_on, np.arange(len(goes_on)))
    while True:
        further = to[to]
        if np.array_equal(further, to):
            return to
        to = further


def _walk(cell: int, receiver: Indices, stream: NDArray[np.bool_], come: Indices, cells: GridCells) -> Indices:
    """From a spring or a confluence to the next, to the sea's first cell or the data's last."""
    way = [cell]
    while True:
        to = int(receiver[way[-1]])
        if to == cells.out:
            break
        way.append(to)
        if not stream[to] or come[to] > 1:
            break
    return np.array(way)


def _parts(way: Indices, catchment: Floats, stream: NDArray[np.bool_]) -> list[Indices]:
    """Pieces along which water grows by less than _GROWN."""
    found, begin = [], 0
    for k in range(1, len(way) - 1):
        if stream[way[k + 1]] and catchment[way[k]] > _GROWN * catchment[way[begin]]:
            found.append(way[begin : k + 1])
            begin = k
    return [*found, way[begin:]]


def _ordered(found: list[Reach], levels: list[Indices], receiver: Indices, stream: NDArray[np.bool_]) -> list[Reach]:
    """The same with Strahler's orders, by river and downstream."""
    rank = np.zeros(len(receiver), dtype=np.int64)
    for k, part in enumerate(levels):
        rank[part] = k
    found.sort(key=lambda reach: (int(rank[reach.cells[0]]), int(reach.cells[0])))
    come: dict[int, list[int]] = {}
    with_order = []
    for reach in found:
        orders = sorted(come.get(int(reach.cells[0]), [1]))
        order = orders[-1] + (1 if len(orders) > 1 and orders[-1] == orders[-2] else 0)
        if stream[reach.cells[-1]]:
            come.setdefault(int(reach.cells[-1]), []).append(order)
        with_order.append(replace(reach, order=order))
    return sorted(with_order, key=lambda reach: (reach.river, int(rank[reach.cells[0]]), int(reach.cells[0])))
