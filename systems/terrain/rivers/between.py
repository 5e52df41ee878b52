"""Nodes between those of cells: mouths, edges of lakes, confluences, and middles of long reaches; and the ends of
mouths, under the sea."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....engine.surface.noise import pcg3d
from ..drainage.cells import CellGrid
from ..drainage.streams import StreamCells, mouth_directions, unpacked_discharge
from .form import BANK_M, BANK_SHARE
from .widths import DEPTH, FLAT, HALF_WIDTH, LEVEL, REACH, half_width_m, narrowest

__all__ = ["Added", "Course", "confluences", "estuaries", "lake_edges", "middles", "mouths"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

_FURTHEST_EDGE = 0.6
"""A lake's edge is no further from the lake's node than this share of the way to the river's."""
_BAR_M = 2500.0
"""Rivers cut on so far beyond their mouths, on a planet of Earth's size: relief that their cells can't show is a bar
before half of them."""
_WIDER, _WIDER_M = 2.0, 20.0
"""A river that joins one more than so many times as wide, and so much, gets a node where it joins it: else it would
widen all the way from its last cell."""
_BESIDE, _FURTHEST_BESIDE = 1.1, 0.5
"""Where that is: in half widths of the wider river, and as a share of the way at most."""
_LONG = 1.0
"""Reaches longer than this, in cells, have a node in their middle."""
_BOW, _ASIDE = 0.1, 0.18
"""Of middles: the curve's part, where 1/16 gives a smooth one, and furthest to a side, by their length."""


@dataclass(frozen=True, eq=False)
class Course:
    """The nodes of cells (N,)."""

    grid: CellGrid
    streams: StreamCells
    radius_m: float
    here: Floats
    """(N, 3) unit directions"""
    to: Indices
    """the node downstream, N at mouths"""
    sea: Floats
    """(M, 3) middles of the sea's cells beyond the mouths"""
    rivers: Floats
    """(6, N), see widths.py"""
    lakes: Floats

    @property
    def lake(self) -> NDArray[np.bool_]:
        """Nodes of lakes."""
        return self.streams.lake > 0

    def inland(self) -> Indices:
        """Those that go on to another node."""
        return np.flatnonzero(self.streams.mouth == 0)

    def rivers_only(self) -> Indices:
        """Of these the ones with no lake at either end."""
        found, lake = self.inland(), self.lake
        return found[~lake[found] & ~lake[self.to[found]]]

    def main(self) -> Indices:
        """(N,) of the nodes that go to each the one with the most water; of equals the last. -1: none."""
        found, rising = np.full(len(self.to), -1), self.inland()
        discharge = unpacked_discharge(self.streams.discharge)
        rising = rising[np.argsort(discharge[rising], kind="stable")]
        found[self.to[rising]] = rising
        return found


@dataclass(frozen=True, eq=False)
class Added:
    """Nodes (K,), each on the way from one to the next."""

    upper: Indices
    """the cell's node before"""
    direction: Floats
    """(K, 3)"""
    rows: Floats
    """(6, K)"""
    lake: bool


def mouths(course: Course) -> Added:
    """At the shore, at the sea's level."""
    upper = np.flatnonzero(course.streams.mouth)
    parts = course.streams.mouth[upper].astype(np.float64)
    rows = course.rivers[:, upper].copy()
    rows[LEVEL] = 0.0
    return Added(upper, mouth_directions(course.here[upper], course.sea, parts), rows, lake=False)


def estuaries(course: Course, scale: float) -> Added:
    """Beyond the mouths of rivers, in narrow valleys, so far below the sea that banks drown. scale: of valleys."""
    # By all of their water, as where rivers join.
    wet = half_width_m(unpacked_discharge(course.streams.discharge).astype(np.float64)) > 0.0
    ends = course.streams.mouth > 0
    upper, sea = np.flatnonzero(ends & wet), course.sea[wet[ends]]
    parts = course.streams.mouth[upper].astype(np.float64)
    mouth, way = mouth_directions(course.here[upper], sea, parts), sea - course.here[upper]
    share = np.minimum(_BAR_M * scale / (_lengths(way) * course.radius_m), 1.0)
    rows = course.rivers[:, upper].copy()
    rows[LEVEL] = -1.0 - 2.0 * (BANK_M + BANK_SHARE * rows[DEPTH])
    rows[FLAT], rows[REACH] = narrowest(rows[HALF_WIDTH], scale)
    return Added(upper, _unit(mouth + way * share[:, None]), rows, lake=False)


def lake_edges(course: Course) -> Added:
    """Where a river comes to a lake or leaves it: as high as the lake and as wide as the river."""
    upper, lake = course.inland(), course.lake
    upper = upper[lake[upper] != lake[course.to[upper]]]
    wet = np.where(lake[upper], upper, course.to[upper])
    dry = np.where(lake[upper], course.to[upper], upper)
    wet_place, dry_place = course.here[wet], course.here[dry]
    length_m = _lengths(wet_place - dry_place) * course.radius_m
    share = np.minimum(course.lakes[HALF_WIDTH, wet] / length_m, _FURTHEST_EDGE)
    rows = course.rivers[:, dry].copy()
    rows[LEVEL] = course.lakes[LEVEL, wet]
    return Added(upper, _unit(wet_place + (dry_place - wet_place) * share[:, None]), rows, lake=True)


def confluences(course: Course, main: Indices) -> Added:
    """At the bank of a much wider river: as wide as the one that joins it."""
    upper, to = course.rivers_only(), course.to
    upper = upper[main[to[upper]] != upper]
    # By all of their water, so that how much of it there is to be changes no node's number.
    width = half_width_m(unpacked_discharge(course.streams.discharge).astype(np.float64))
    upper = upper[width[to[upper]] > _WIDER * width[upper] + _WIDER_M]
    here, there = course.here[upper], course.here[to[upper]]
    wider = np.maximum(course.rivers[HALF_WIDTH, to[upper]], _WIDER_M)
    share = np.minimum(_BESIDE * wider / (_lengths(here - there) * course.radius_m), _FURTHEST_BESIDE)
    rows, below = course.rivers[:, upper].copy(), course.rivers[:, to[upper]]
    for row in (LEVEL, FLAT, REACH):
        rows[row] = below[row] + (rows[row] - below[row]) * share
    return Added(upper, _unit(there + (here - there) * share[:, None]), rows, lake=False)


def middles(course: Course, main: Indices, taken: Indices) -> Added:
    """In the middle of long reaches, except from springs and where there is another node (K,): on the curve through
    the four nodes around (Dyn, Levin and Gregory 1987, with a wider bow), and a little to a side."""
    here, to = course.here, course.to
    free = np.ones(len(to), dtype=bool)
    free[taken] = False
    upper = course.rivers_only()
    long = _lengths(here[upper] - here[to[upper]]) > _LONG * np.sqrt(4.0 * np.pi / course.grid.count)
    upper = upper[long & free[upper] & (main[upper] >= 0)]
    a, b, before = here[upper], here[to[upper]], here[main[upper]]
    last = to[to[upper]]
    goes_on = (last < len(here))[:, None]
    after = np.where(goes_on, here[np.minimum(last, len(here) - 1)], 2.0 * b - a)
    number = course.streams.cells[upper].astype(np.uint32)
    word = pcg3d(number, np.full_like(number, 13), np.zeros_like(number))[0]
    side = ((word >> np.uint32(8)).astype(np.float64) * 2.0**-23 - 1.0) * _ASIDE
    bow = ((a - before) - (after - b)) * _BOW
    rows = course.rivers[:, upper].copy()
    for row in (LEVEL, FLAT, REACH):
        rows[row] = 0.5 * (rows[row] + course.rivers[row, to[upper]])
    return Added(upper, _unit(0.5 * (a + b) + bow + _across(a, b - a) * side[:, None]), rows, lake=False)


def _across(up: Floats, way: Floats) -> Floats:
    """(N, 3) level, to the left of ways (N, 3) and as long."""
    x, y, z = up.T
    u, v, w = way.T
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=1)


def _lengths(vectors: Floats) -> Floats:
    x, y, z = vectors.T
    return np.sqrt(x * x + y * y + z * z)


def _unit(vectors: Floats) -> Floats:
    return vectors / _lengths(vectors)[:, None]
