"""Rivers as tables that the float64 twin and the GPU read alike: lines, and which of them pass a cell of a lattice.

The lattice has 256 to 512 cells on the planet's radius, a power of two in metres (16 km on Earth), like the noises'
own: a cell's number and a place in it are exact wherever one stands, so there are no faces, poles or seams. A line
belongs to all cells from which its valley can be reached.
"""

from __future__ import annotations

import hashlib
import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....engine.surface.noise import Lattice
from ....engine.table_cache import TableCache
from .banks import bank_lattice
from .bends import BEND_CELLS, BEND_SHARES, bend_amplitudes_m, bend_lattice, river_cell_m
from .form import HELD
from .node_arrays import RiverNodes

__all__ = ["BESIDE_M", "CELL_STEPS", "RiverTable", "cell_keys", "river_table"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]

CELL_STEPS = 2**22
"""Steps of a node's place in a cell: 4 mm on Earth."""
BESIDE_M = 100.0
"""How far from the water's edge a bank is wetter than the rain makes it; as BESIDE_M of terrain/rivers.glsl."""
_FEW_KEYS = 256
"""So few keys are looked up as fast among all as in their rows."""
_HALF = 512
"""Cells from the planet's centre to either side, at most."""


def cell_keys(cells: NDArray[np.int64]) -> NDArray[np.int64]:
    """(N,) one number each for cells (3, N)."""
    x, y, z = cells + _HALF
    return (z << 20) | (y << 10) | x


@dataclass(frozen=True, eq=False)
class RiverTable:
    """Lines of rivers and lakes on one planet. Equal only to itself."""

    radius_m: float
    cell_m: float
    seed: int
    place: Integers
    """(N, 3) of nodes on the reference sphere, in steps"""
    to: Integers
    """(N,) the node downstream, -1: none"""
    values: NDArray[np.float32]
    """(N, 8) at nodes: level, half width of the water, depth, half width of the floor, reach, metres; 1 for a lake;
    discharge, m3/s; 0"""
    keys: NDArray[np.int64] = field(repr=False)
    """(C,) of cells with lines, rising"""
    begin: Integers = field(repr=False)
    """(C + 1,) where in `lines` each cell's begin"""
    lines: Integers = field(repr=False)
    """nodes at whose lines a cell's places have to look"""
    given: bool = False
    """somebody's map says where water is: no warp bends its lines, nor do they carve; lakes are where ground within
    reach of a lake's line lies below its level"""
    uneven: float = 0.0
    """how uneven banks are, 0..1"""

    @cached_property
    def bends(self) -> Lattice:
        """Octaves of the vector noise that bends lines."""
        return bend_lattice(self.cell_m, self.seed)

    @cached_property
    def bend_m(self) -> Floats:
        """Amplitudes of the warp's octaves, rounded to float32."""
        return bend_amplitudes_m(self.cell_m) * float(not self.given)

    @cached_property
    def steepest_per_m(self) -> float:
        """The largest share of a height above the river that is gained a metre away from it."""
        drawn = self.to >= 0
        return float(2.0 / (self.values[drawn, 4] - self.values[drawn, 3]).min()) if drawn.any() else 0.0

    @cached_property
    def far_m(self) -> NDArray[np.float32]:
        """(N,) how far from the lines that begin at nodes they may say something: no line says more beyond its reach,
        or beyond where ground is held back (form.river_raise)."""
        own = np.maximum(self.values[:, 4], self.values[:, 3] + HELD * self.values[:, 4])
        return np.where(self.to >= 0, np.maximum(own, own[self.to]), np.float32(0.0))

    @cached_property
    def rows(self) -> Integers:
        """(2^20 + 1,) where in `keys` those with equal z and y begin: nearer to what is looked for than all of them."""
        return np.searchsorted(self.keys, np.arange(2**20 + 1, dtype=np.int64) << 10).astype(np.int32)

    def cells_at(self, keys: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Which of the cells (N,) have lines (K,), and their numbers among all that have (K,)."""
        if not len(self.keys):
            return np.empty(0, np.int64), np.empty(0, np.int64)
        low = self._found(keys) if len(keys) > _FEW_KEYS else np.searchsorted(self.keys, keys)
        near = np.flatnonzero(self.keys.take(low, mode="clip") == keys)
        return near, low[near]

    def _found(self, keys: NDArray[np.int64]) -> NDArray[np.int64]:
        """np.searchsorted, which takes longer for many."""
        row = keys >> 10
        low, high = (self.rows.take(row + k).astype(np.int64) for k in (0, 1))
        for _ in range(int((high - low).max(initial=0)).bit_length()):
            middle = (low + high) >> 1
            below = self.keys.take(middle, mode="clip") < keys
            low, high = np.where(below, middle + 1, low), np.where(below, high, middle)
        return low

    @cached_property
    def half_width_m(self) -> NDArray[np.float32]:
        """(N,) of the water of the lines that begin at nodes, at their wider end; 0 without a line or water."""
        return _half_widths(self.to, self.values)

    @cached_property
    def banks(self) -> Lattice:
        """Octaves of the noise that makes banks uneven."""
        return bank_lattice(self.cell_m / CELL_STEPS)

    @property
    def nbytes(self) -> int:
        """Memory of the arrays."""
        return sum(a.nbytes for a in (self.place, self.to, self.values, self.keys, self.begin, self.lines))


def river_table(nodes: RiverNodes, radius_m: float, seed: int, given: bool = False, banks: float = 1.0) -> RiverTable:
    """The table of these nodes on a planet of that radius. seed: of the bends. given: as RiverTable has it. banks: how
    uneven they are; where they are given, not at all."""
    cell_m = river_cell_m(radius_m)
    place = np.rint(nodes.direction * (radius_m / cell_m * CELL_STEPS)).astype(np.int64)
    place = np.clip(place, -(2**31), 2**31 - 1).astype(np.int32)
    values = np.zeros((len(place), 8), dtype=np.float32)
    columns = (nodes.level_m, nodes.half_width_m, nodes.depth_m, nodes.flat_m, nodes.reach_m, nodes.lake)
    for k, column in enumerate((*columns, nodes.discharge_m3_s)):
        values[:, k] = column
    reach = values[:, 4]
    if given:  # no valleys: banks may be wider than what lines say of the ground
        reach = np.where(nodes.lake, reach, np.maximum(reach, values[:, 1] + np.float32(BESIDE_M)))
    keys, begin, lines = _kept_cells(place, nodes.to, reach / cell_m, radius_m / cell_m)
    lines = _widest_first(lines, begin, _half_widths(nodes.to, values))
    uneven = 0.0 if given else banks
    return RiverTable(
        radius_m, cell_m, seed, place, nodes.to.astype(np.int32), values, keys, begin, lines, given, uneven
    )


def _half_widths(to: Integers, values: NDArray[np.float32]) -> NDArray[np.float32]:
    """(N,) of the water of the lines that begin at nodes, at their wider end."""
    return np.where(to >= 0, np.maximum(values[:, 1], values[to, 1]), np.float32(0.0))


def _widest_first(lines: Integers, begin: Integers, half_width: NDArray[np.float32]) -> Integers:
    """Those of each cell by how wide they are: who looks from afar leaves out the others."""
    rank = np.empty(len(half_width), dtype=np.int64)
    rank[np.argsort(-half_width, kind="stable")] = np.arange(len(half_width))
    cell = np.repeat(np.arange(len(begin) - 1), np.diff(begin))
    return lines[np.argsort(cell * len(half_width) + rank[lines], kind="stable")]


_CHUNK = 1 << 14
_VERSION = "1"
"""Part of the cache's key: change it with what `_cells_of` finds."""


def _kept_cells(
    place: Integers, to: Integers, reach: NDArray[np.float32], radius: float
) -> tuple[NDArray[np.int64], Integers, Integers]:
    """`_cells_of`, from the user's cache folder where somebody has looked before: a second and a half for Earth."""
    if len(to) < _FEW:
        return _cells_of(place, to, reach, radius)
    cache = TableCache("rivers")
    digest = hashlib.sha256(place.tobytes() + to.tobytes() + reach.tobytes()).hexdigest()
    key, counts = cache.key(_VERSION, digest, repr(radius)), cache.key(_VERSION, digest, repr(radius), "counts")
    sizes = cache.load(counts, {"sizes": (2,)}, np.int64)
    if sizes is not None:
        cells, entries = (int(n) for n in sizes["sizes"])
        held = cache.load(key, {"keys": (cells,), "begin": (cells + 1,), "lines": (entries,)}, np.int32)
        if held is not None:
            return held["keys"].astype(np.int64), held["begin"], held["lines"]
    keys, begin, lines = _cells_of(place, to, reach, radius)
    cache.save(key, {"keys": keys.astype(np.int32), "begin": begin, "lines": lines})
    cache.save(counts, {"sizes": np.array([len(keys), len(lines)])})
    return keys, begin, lines


_FEW = 20_000
"""Nodes so few are looked at as fast as a file is read."""


def _cells_of(
    place: Integers, to: Integers, reach: NDArray[np.float32], radius: float
) -> tuple[NDArray[np.int64], Integers, Integers]:
    """For each cell that the sphere passes the lines that reach into it; lengths in cells."""
    line = np.flatnonzero(to >= 0)
    # Tangential parts alone are compared, and the warp adds its own on all three axes.
    bent = sum(a * b for a, b in zip(BEND_CELLS, BEND_SHARES, strict=True)) * math.sqrt(3.0)

    def look(start: int) -> list[tuple[NDArray[np.int64], NDArray[np.int64]]]:
        part = line[start : start + _CHUNK]
        a, b = place[part] / CELL_STEPS, place[to[part]] / CELL_STEPS
        far = np.maximum(reach[part], reach[to[part]]).astype(np.float64) + bent
        return [(cell_keys(cells.T), part[number]) for number, cells in _near_cells(a, b, far, radius)]

    with ThreadPoolExecutor() as pool:
        found = [pair for pairs in pool.map(look, range(0, len(line), _CHUNK)) for pair in pairs]
    if not found:
        return np.empty(0, np.int64), np.zeros(1, np.int32), np.empty(0, np.int32)
    keys, lines = (np.concatenate(part) for part in zip(*found, strict=True))
    order = np.lexsort((lines, keys))
    keys, lines = keys[order], lines[order]
    keys, first = np.unique(keys, return_index=True)
    return keys, np.append(first, len(lines)).astype(np.int32), lines.astype(np.int32)


def _near_cells(a: Floats, b: Floats, far: Floats, radius: float) -> list[tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """Pairs of (index of a line, cell (3,)): cells on the sphere no further than `far` from the line a b, in cells."""
    low = np.floor(np.minimum(a, b) - far[:, None]).astype(np.int64)
    high = np.floor(np.maximum(a, b) + far[:, None]).astype(np.int64)
    size = high - low + 1
    found = []
    along = b - a
    square = np.maximum((along * along).sum(axis=1), 1e-12)
    for dz in range(int(size[:, 2].max())):
        for dy in range(int(size[:, 1].max())):
            for dx in range(int(size[:, 0].max())):
                number = np.flatnonzero((dx < size[:, 0]) & (dy < size[:, 1]) & (dz < size[:, 2]))
                cell = low[number] + (dx, dy, dz)
                inner = np.maximum(np.maximum(cell, -(cell + 1)), 0)
                outer = np.maximum(np.abs(cell), np.abs(cell + 1))
                on = ((inner**2).sum(axis=1) <= (radius + 0.01) ** 2) & ((outer**2).sum(axis=1) >= (radius - 0.01) ** 2)
                number, cell = number[on], cell[on]
                # Alternating projections between box and line converge to their distance from above.
                origin, way = a[number], along[number]
                spot = foot = cell + 0.5
                for _ in range(3):
                    t = np.clip(((spot - origin) * way).sum(axis=1) / square[number], 0.0, 1.0)
                    foot = origin + t[:, None] * way
                    spot = np.clip(foot, cell, cell + 1)
                away = np.sqrt(((foot - spot) ** 2).sum(axis=1))
                near = away <= far[number] + _SLACK
                found.append((number[near], cell[near]))
    return found


_SLACK = 0.02
"""Cells: what the distance between a box and a line may still be too long by."""
