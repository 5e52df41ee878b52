"""The way down from every cell of land to the sea, out of every hollow by its lowest pass.

Cells go to their steepest neighbour; what ends in a hollow leaves it over the pass that a flood would find: hollows and
passes are a graph, whose minimum spanning tree from the sea says which pass (Cordonnier, Bovy and Braun 2019, "A
versatile, linear complexity algorithm for flow routing in topographies with depressions"; Boruvka's method). The way
from a hollow's floor to its pass is turned round, as if water had cut it. Compared are heights and, where they are
equal, numbers of cells: the same ground gives the same rivers, to the bit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Flow", "add_downstream", "flow_of", "levels_of"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Near = NDArray[np.integer]


@dataclass(frozen=True)
class Flow:
    """Where water goes. Arrays (N,) by cell; of the sea's cells each is its own receiver."""

    receiver: Indices
    order: Indices
    """cells from the sea upwards: none before its receiver"""
    starts: Indices
    """where in `order` each level begins, 0 the sea's; and its end"""
    hollows: int
    """of the ground, that had no way out"""


def flow_of(height_m: Floats, sea: NDArray[np.bool_], neighbours: Near, distance: NDArray[np.floating]) -> Flow:
    """height_m (N,), sea (N,): cells that water ends at; neighbours (N, K), -1: none, distance (N, K) to them, above 0
    even where there is none.

    ValueError where some land has no way to the sea.
    """
    receiver = _steepest(height_m, sea, neighbours, distance)
    root = _roots(receiver)
    is_root = receiver == np.arange(len(receiver))
    hollow = np.flatnonzero(is_root & ~sea)
    if len(hollow):
        # The sea is basin 0.
        number = np.zeros(len(receiver), dtype=np.int64)
        number[hollow] = 1 + np.arange(len(hollow))
        _leave_hollows(receiver, number[root], hollow, _passes(height_m, number[root], neighbours))
    order, starts = levels_of(receiver)
    return Flow(receiver, order, starts, len(hollow))


def _steepest(height_m: Floats, sea: NDArray[np.bool_], neighbours: Near, distance: NDArray[np.floating]) -> Indices:
    """The neighbour down the steepest way, the lower number of equals; itself where none is lower, and in the sea."""
    own = np.arange(len(height_m))
    receiver, steepest = own.copy(), np.zeros(len(height_m))
    for k in range(neighbours.shape[1]):
        to = neighbours[:, k]
        slope = np.where(to >= 0, height_m - height_m[to], -1.0) / distance[:, k]
        better = (slope > steepest) | ((slope == steepest) & (slope > 0.0) & (to < receiver))
        receiver = np.where(better, to, receiver)
        steepest = np.where(better, slope, steepest)
    return np.where(sea, own, receiver)


def _roots(receiver: Indices) -> Indices:
    """Where the way from each cell ends."""
    root = receiver
    while True:
        further = root[root]
        if np.array_equal(further, root):
            return root
        root = further


@dataclass(frozen=True)
class _Passes:
    """Lowest ways between basins (M,): the two cells, and the basins that they are in; the lowest first."""

    inside: Indices
    outside: Indices
    basin: Indices
    other: Indices


def _passes(height_m: Floats, basin: Indices, neighbours: Near) -> _Passes:
    """Sorted from the lowest up, equals by their cells' numbers; one for each pair of basins."""
    found = []
    for k in range(neighbours.shape[1]):
        to = neighbours[:, k]
        # Each pair once; -1 stands for none.
        here = np.flatnonzero((to > np.arange(len(to))) & (basin != basin[to]))
        found.append(np.stack([here, to[here]]))
    here, there = np.concatenate(found, axis=1)
    a, b = basin[here], basin[there]
    low, high = np.minimum(a, b), np.maximum(a, b)
    height = np.maximum(height_m[here], height_m[there])
    sorted_ = np.lexsort((there, here, height))
    pair = (low * (int(basin.max()) + 1) + high)[sorted_]
    _, first = np.unique(pair, return_index=True)
    kept = sorted_[np.sort(first)]
    return _Passes(here[kept], there[kept], a[kept], b[kept])


def _leave_hollows(receiver: Indices, basin: Indices, hollow: Indices, passes: _Passes) -> None:
    """Turn round the ways from hollows' floors to the passes that the tree of lowest passes leads over."""
    chosen = _spanning(len(hollow) + 1, passes)
    inside, outside = _towards_the_sea(len(hollow) + 1, passes, chosen, basin)
    cell, new = inside, outside
    while len(cell):
        old = receiver[cell]
        receiver[cell] = new
        going_on = old != cell
        cell, new = old[going_on], cell[going_on]


def _spanning(count: int, passes: _Passes) -> Indices:
    """Indices of the passes in the minimum spanning tree (Boruvka 1926): each part takes its lowest pass, again and
    again. Passes are sorted, so the lowest is the one with the lowest index, and there are no equals."""
    part = np.arange(count)
    edges = np.arange(len(passes.basin))
    chosen: list[Indices] = []
    while True:
        a, b = part[passes.basin[edges]], part[passes.other[edges]]
        apart = a != b
        edges, a, b = edges[apart], a[apart], b[apart]
        if not len(edges):
            break
        lowest = np.full(count, len(passes.basin))
        np.minimum.at(lowest, a, edges)
        np.minimum.at(lowest, b, edges)
        parts = np.flatnonzero(lowest < len(passes.basin))
        edge = lowest[parts]
        chosen.append(np.unique(edge))
        ends = part[passes.basin[edge]], part[passes.other[edge]]
        to = np.where(ends[0] == parts, ends[1], ends[0])
        joined = np.arange(count)
        joined[parts] = to
        # Two parts that chose the same pass: the lower number leads.
        mutual = joined[joined] == np.arange(count)
        joined = np.where(mutual, np.minimum(joined, np.arange(count)), joined)
        part = _roots(joined)[part]
    if (part != part[0]).any():
        raise ValueError(f"drainage: {int((part != part[0]).sum())} hollows have no way to the sea; is there any?")
    return np.concatenate(chosen) if chosen else np.empty(0, dtype=np.int64)


def _towards_the_sea(count: int, passes: _Passes, chosen: Indices, basin: Indices) -> tuple[Indices, Indices]:
    """For each hollow the cell at its pass and the cell beyond, by a walk over the tree from the sea."""
    ends = np.concatenate([passes.inside[chosen], passes.outside[chosen]])
    others = np.concatenate([passes.outside[chosen], passes.inside[chosen]])
    from_ = basin[ends]
    sorted_ = np.argsort(from_, kind="stable")
    ends, others, from_ = ends[sorted_], others[sorted_], from_[sorted_]
    begin = np.searchsorted(from_, np.arange(count + 1))
    inside, outside = np.full(count, -1), np.full(count, -1)
    seen = np.zeros(count, dtype=bool)
    seen[0] = True
    front = np.array([0])
    while len(front):
        many = begin[front + 1] - begin[front]
        edge = np.repeat(begin[front] - np.concatenate([[0], np.cumsum(many)[:-1]]), many) + np.arange(many.sum())
        new = ~seen[basin[others[edge]]]
        edge = edge[new]
        front = basin[others[edge]]
        inside[front], outside[front] = others[edge], ends[edge]
        seen[front] = True
    return inside[1:], outside[1:]


def levels_of(receiver: Indices) -> tuple[Indices, Indices]:
    """Cells by the number of steps to the end of their way: (order (N,), starts (levels + 1,)), as in Flow."""
    steps, to = (receiver != np.arange(len(receiver))).astype(np.int64), receiver
    while True:
        further = steps + steps[to]
        if np.array_equal(further, steps):
            break
        steps, to = further, to[to]
    order = np.argsort(steps, kind="stable")
    return order, np.searchsorted(steps[order], np.arange(int(steps.max()) + 2))


def add_downstream(flow: Flow, own: Floats) -> Floats:
    """Of each cell (N,) what it has itself and what all cells above it have, added in the order of their numbers."""
    total = own.copy()
    for level in range(len(flow.starts) - 2, 0, -1):
        cells = flow.order[flow.starts[level] : flow.starts[level + 1]]
        np.add.at(total, flow.receiver[cells], total[cells])
    return total
