"""Land that water has carved: the shape of its river network, and where drops end that run down its final ground."""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray

from ...systems.terrain.drainage.solve import Solution
from ...systems.terrain.height import TerrainField, TerrainParams
from ...systems.terrain.rivers.nodes import nodes_of
from ...systems.terrain.rivers.valleys import valleys, waters

__all__ = ["Descent", "NetworkShape", "bifurcation", "descend", "network_shape"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_LARGE_M2 = 1e11
"""Catchments whose longest stream says how long streams get."""
_POND = 20
"""Steps to either side that a pond may reach."""


@dataclass(frozen=True)
class NetworkShape:
    """Numbers that networks of real rivers are described by."""

    cells: int
    """of land"""
    undrained: int
    """cells of land whose water never comes to the sea"""
    climbing: int
    """reaches between river nodes that climb downstream"""
    concavity: float
    """theta of slope ~ area^-theta"""
    hack: float
    """h of length ~ area^h (Hack 1957)"""
    ratios: list[float]
    """streams of each of Strahler's orders by those of the next"""


@dataclass(frozen=True)
class Descent:
    """Where drops end, as shares of all."""

    places: int
    sea: float
    water: float
    """in a river or a lake"""
    floor: float
    """on the floor of a mapped stream that is dry or too narrow to count"""
    pit: float
    """in a pit that is deeper or wider than what may be filled"""
    lost: float
    """still on the way"""
    median_way_m: float
    """of those that came to a mapped stream, a lake or the sea"""

    @property
    def arrived(self) -> float:
        """Share that came to a mapped stream, a lake or the sea."""
        return self.sea + self.water + self.floor


def network_shape(solution: Solution, params: TerrainParams) -> NetworkShape:
    """Of the cells that a ground's rivers follow; slopes where the ground is cut: springs are not."""
    network, streams = solution.network, solution.streams
    index = network.index[streams.cells]
    nodes = nodes_of(network.grid, streams, params)
    to = network.receiver[index]
    level = np.zeros(len(network.cells))
    level[index] = nodes.level_m[: len(index)]
    apart = np.linalg.norm(network.places[index] - network.places[to], axis=1) * params.radius_m
    spring = np.ones(len(level), dtype=bool)
    spring[to] = False
    slope, area = (level[index] - level[to]) / apart, network.catchment_m2[index]
    slope, area = slope[~spring[index]], area[~spring[index]]
    edges = np.quantile(area, np.linspace(0.0, 1.0, 9))
    bins = [(area >= a) & (area <= b) for a, b in pairwise(edges)]
    mean = np.array([(np.log(area[b].mean()), np.log(slope[b].mean())) for b in bins])

    longest = _longest(solution, params.radius_m)
    land = np.flatnonzero(~network.sea)
    large = land[(longest[land] > 0.0) & (network.catchment_m2[land] > _LARGE_M2)]
    reached = _ends(network.receiver)[land]
    follows = nodes.to >= 0
    return NetworkShape(
        cells=len(land),
        undrained=int((~network.sea[reached]).sum()),
        climbing=int((nodes.level_m[nodes.to[follows]] > nodes.level_m[follows]).sum()),
        concavity=float(-np.polyfit(mean[:, 0], mean[:, 1], 1)[0]),
        hack=float(np.polyfit(np.log(network.catchment_m2[large]), np.log(longest[large]), 1)[0]),
        ratios=bifurcation(network.receiver, index),
    )


def _ends(receiver: Ints) -> Ints:
    """(N,) the cell where each cell's water comes to rest, by doubling the way looked ahead."""
    ahead = receiver.astype(np.int64)
    for _ in range(64):
        further = ahead[ahead]
        if np.array_equal(further, ahead):
            break
        ahead = further
    return ahead


def _longest(solution: Solution, radius_m: float) -> Floats:
    """(N,) metres of the longest stream down to the end of each cell's step; 0 at springs."""
    network = solution.network
    land = np.flatnonzero(~network.sea)
    step = np.zeros(len(network.cells))
    step[land] = np.linalg.norm(network.places[land] - network.places[network.receiver[land]], axis=1) * radius_m
    above = np.zeros(len(step))
    for cell in network.flow.order[::-1]:
        to = network.receiver[cell]
        if to != cell:
            above[to] = max(above[to], above[cell] + step[cell])
    return np.where(above > 0.0, above + step, 0.0)


def bifurcation(receiver: NDArray[np.integer], streams: NDArray[np.integer]) -> list[float]:
    """Streams of each order by those of the next (Strahler 1957)."""
    order = dict.fromkeys(streams.tolist(), 1)
    above: dict[int, list[int]] = {cell: [] for cell in order}
    for cell in order:
        if int(receiver[cell]) in above:
            above[int(receiver[cell])].append(cell)
    waiting = {cell: len(found) for cell, found in above.items()}
    ready = [cell for cell, many in waiting.items() if many == 0]
    while ready:
        cell = ready.pop()
        orders = sorted((order[up] for up in above[cell]), reverse=True)
        if orders:
            order[cell] = orders[0] + (len(orders) > 1 and orders[0] == orders[1])
        to = int(receiver[cell])
        if to in waiting:
            waiting[to] -= 1
            if waiting[to] == 0:
                ready.append(to)
    ends = [order[c] for c in order if order.get(int(receiver[c])) != order[c]]
    many = np.bincount(ends)[1:]
    return [round(float(a / b), 2) for a, b in pairwise(many)]


def descend(
    field: TerrainField, directions: Floats, step_m: float = 25.0, pit_m: float = 3.0, steps: int = 4000
) -> Descent:
    """Drops from unit directions (N, 3), each to the lowest of eight places a step away, until it comes to the sea, to
    water, or to the floor of a mapped stream. Out of a pit it goes where water spills over that fills it by pit_m at
    most, within 20 steps."""
    rivers = field.params.rivers
    end = np.full(len(directions), "lost", dtype="<U5")
    way_m = np.zeros(len(directions))
    at, here = np.arange(len(directions)), np.array(directions, dtype=np.float64)
    height = field.height(here)
    for _ in range(steps):
        arrived = np.where(height <= 0.0, "sea", "")
        if rivers is not None:
            points = np.ascontiguousarray(here.T) * field.radius_m
            floor = valleys(rivers, points).open <= 0.0
            arrived = np.where((arrived == "") & floor, "floor", arrived)
            wet = np.isin(arrived, ("", "floor")) & (waters(rivers, points).beyond_m <= 0.0)
            arrived = np.where(wet, "water", arrived)
        end[at[arrived != ""]] = arrived[arrived != ""]
        left = arrived == ""
        at, here, height = at[left], here[left], height[left]
        if not at.size:
            break
        around = _around(here, step_m / field.radius_m, 8)
        heights = field.height(around.reshape(-1, 3)).reshape(len(at), 8)
        lowest = heights.argmin(axis=1)
        rows = np.arange(len(at))
        down = heights[rows, lowest] < height
        moved_m = np.where(down, step_m, 0.0)
        there, level = around[rows, lowest], heights[rows, lowest]
        stuck = np.flatnonzero(~down)
        if stuck.size:
            place, found, far = _out_of_pit(field, here[stuck], height[stuck], step_m, pit_m)
            there[stuck], level[stuck], moved_m[stuck] = place, found, far * step_m
            end[at[stuck[far == 0]]] = "pit"
        on = moved_m > 0.0
        way_m[at[on]] += moved_m[on]
        at, here, height = at[on], there[on], level[on]
    came = np.isin(end, ("sea", "water", "floor"))
    shares = {name: float((end == name).mean()) for name in ("sea", "water", "floor", "pit", "lost")}
    return Descent(
        len(directions), **shares, median_way_m=float(np.median(way_m[came])) if came.any() else float("nan")
    )


def _around(here: Floats, angle: float, ways: int) -> Floats:
    """(N, ways, 3) unit directions at an angle from each place (N, 3)."""
    side = np.cross(here, np.where(np.abs(here[:, 2:]) < 0.9, (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)))
    side /= np.linalg.norm(side, axis=1)[:, None]
    turn = np.linspace(0.0, 2.0 * np.pi, ways, endpoint=False)
    across = np.cos(turn)[:, None] * side[:, None] + np.sin(turn)[:, None] * np.cross(here, side)[:, None]
    return np.cos(angle) * here[:, None] + np.sin(angle) * across


def _out_of_pit(
    field: TerrainField, here: Floats, height: Floats, step_m: float, pit_m: float
) -> tuple[Floats, Floats, Ints]:
    """Where water leaves that fills the pit up to pit_m: the place (K, 3), its height (K,), and how many steps away it
    is (K,), 0: it stays."""
    place, level, far = here.copy(), height.copy(), np.zeros(len(here), dtype=np.int64)
    reach = np.arange(-_POND, _POND + 1) * (step_m / field.radius_m)
    for k in range(len(here)):
        side = _around(here[k : k + 1], 0.5 * np.pi, 4)[0]
        window = here[k] + reach[:, None, None] * side[0] + reach[None, :, None] * side[1]
        window /= np.linalg.norm(window, axis=2)[..., None]
        found = _spill(field.height(window.reshape(-1, 3)).reshape(window.shape[:2]), float(height[k]), pit_m)
        if found is not None:
            place[k], level[k], far[k] = window[found[:2]], found[2], found[3]
    return place, level, far


def _spill(heights: Floats, level: float, pit_m: float) -> tuple[int, int, float, int] | None:
    """The first place below `level` that a flood from the middle comes to, lowest ways first, no higher than pit_m
    above it: row, column, height, steps from the middle; None where there is none in the window."""
    middle, last = heights.shape[0] // 2, heights.shape[0] - 1
    waiting, known = [(level, middle, middle)], {(middle, middle)}
    while waiting:
        water, row, column = heapq.heappop(waiting)
        there = float(heights[row, column])
        if there < level - 1e-3:
            return row, column, there, max(abs(row - middle), abs(column - middle))
        if water > level + pit_m:
            return None
        for at in product((row - 1, row, row + 1), (column - 1, column, column + 1)):
            if at not in known and min(at) >= 0 and max(at) <= last:
                known.add(at)
                heapq.heappush(waiting, (max(water, float(heights[at])), *at))
    return None
