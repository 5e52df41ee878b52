"""Lines of water (rivers/table.py) for a vector map: rivers as they run, and for each lake some round ones that reach
over all of it, and over no lower ground beyond its shore: there the ground says where it ends."""

from __future__ import annotations

import heapq
import logging
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ....engine.real_ground.lattice import directions_at
from ..rivers.node_arrays import RiverNodes
from ..rivers.table import RiverTable, river_table
from ..rivers.widths import WIDTH_BY_ROOT
from .bodies import Body, Ground, metres_per_deg
from .streams import Way, simplified

__all__ = ["water_table"]

log = logging.getLogger(__name__)

Floats = NDArray[np.float64]
_MOST_LINES = 480
"""In a cell, of 511 that the GPU knows of."""
_FIRST_M, _MOST_M = 1.0, 120.0
"""What the narrowest rivers' lines may leave out, and as far as that goes before some rivers are left out."""
_SHORE_M = 60.0
"""Beyond a lake's shore the ground keeps its water in (raster.py)."""
_DRY_M = 0.5
_CELLS, _FEWEST_M, _WIDER = 80, 8.0, 0.35
"""A lake is looked at on so many cells along its longer side, at least so wide, and by so much beyond it."""
_MOST_ROUND = 48


def water_table(
    lakes: Sequence[Body], ways: Sequence[Way], ground: Ground, radius_m: float, seed: int, what: str
) -> RiverTable | None:
    """None where there is no water above the sea. what: the file, for warnings."""
    rounds = [_round_lines(k, lakes, ways, ground, radius_m) for k in range(len(lakes))]
    tolerance, used = _FIRST_M, list(ways)
    narrowest = min((float(way.half_m.max()) for way in ways), default=1.0)

    def finer(way: Way) -> float:
        """Where room is scarce wide rivers, which are seen from afar, keep their bends."""
        return narrowest / float(way.half_m.max())

    while True:
        rows = [_of_way(way, simplified(way, max(tolerance * finer(way), _FIRST_M), radius_m)) for way in used]
        nodes = _nodes([*rows, *rounds])
        if nodes is None:
            return None
        table = river_table(nodes, radius_m, seed, given=True)
        crowded = np.diff(table.begin).max(initial=0)
        if crowded <= _MOST_LINES:
            break
        if tolerance < _MOST_M:
            tolerance *= 2.0
        elif used:
            used.sort(key=lambda way: -float(way.half_m.max()))
            used = used[: len(used) * 3 // 4]
        else:
            rounds = rounds[: len(rounds) * 3 // 4]
    left = len(ways) - len(used)
    if left or len(rounds) < len(lakes):
        log.warning(
            "%s: %d of %d waterways and %d of %d lakes are left out, where more than %d lines lie within %g km; give "
            "the widest ones alone, or smaller pieces", what, left, len(ways), len(lakes) - len(rounds), len(lakes),
            _MOST_LINES, table.cell_m / 1e3,
        )  # fmt: skip
    elif tolerance > _FIRST_M:
        log.info("%s: rivers are drawn to %g m", what, tolerance)
    return table


_Rows = tuple[Floats, Floats, Floats, bool]
"""Places (N, 2), level and half width (N,), whether a lake's."""


def _of_way(way: Way, kept: NDArray[np.int64]) -> list[_Rows]:
    """Pieces of a way: what lies in a lake as a whole is the lake's."""
    pieces, begin = [], 0
    wet = (way.lake[kept[:-1]] >= 0) & (way.lake[kept[:-1]] == way.lake[kept[1:]])
    for k in [*np.flatnonzero(wet).tolist(), len(kept) - 1]:
        at = kept[begin : k + 1]
        if len(at) > 1:
            pieces.append((way.points[at], way.level_m[at], way.half_m[at], False))
        begin = k + 1
    return pieces


def _nodes(parts: Sequence[list[_Rows]]) -> RiverNodes | None:
    rows = [row for part in parts for row in part]
    if not rows:
        return None
    places = np.concatenate([r[0] for r in rows])
    level, half = (np.concatenate([r[k] for r in rows]) for k in (1, 2))
    counts = [len(r[0]) for r in rows]
    lake = np.repeat([r[3] for r in rows], counts)
    to = np.arange(1, len(places) + 1)
    to[np.cumsum(counts) - 1] = -1
    discharge = np.where(lake, 0.0, (2.0 * half / WIDTH_BY_ROOT) ** 2)
    depth = np.where(lake, 4.0, np.maximum(0.27 * discharge**0.39, 0.4))
    flat = 1.05 * half
    singles = (level, half, depth, flat, 1.1 * half + 20.0)
    names = ("level_m", "half_width_m", "depth_m", "flat_m", "reach_m")
    return RiverNodes(
        direction=np.ascontiguousarray(directions_at(places[:, 1], places[:, 0]).T),
        to=to.astype(np.int32),
        lake=lake,
        discharge_m3_s=discharge.astype(np.float32),
        **{name: values.astype(np.float32) for name, values in zip(names, singles, strict=True)},
    )


def _round_lines(
    number: int, lakes: Sequence[Body], ways: Sequence[Way], ground: Ground, radius_m: float
) -> list[_Rows]:
    """Round lines over a lake."""
    lake = lakes[number]
    west, south, east, north = lake.area.bounds
    x, y = metres_per_deg(radius_m, 0.5 * (south + north))
    cell_m = max(max((east - west) * x, (north - south) * y) / _CELLS, _FEWEST_M)
    more_m = _WIDER * max((east - west) * x, (north - south) * y) + 2.0 * cell_m
    columns = int(np.ceil(((east - west) * x + 2.0 * more_m) / cell_m))
    rows = int(np.ceil(((north - south) * y + 2.0 * more_m) / cell_m))
    first = west - more_m / x, min(north + more_m / y, 90.0)

    def on_cells(points: Floats) -> tuple[Floats, Floats]:
        return (points[..., 0] - first[0]) * (x / cell_m) - 0.5, (first[1] - points[..., 1]) * (y / cell_m) - 0.5

    def share_of(area: Body) -> Floats:
        ends = area.area.edges.reshape(-1, 2, 2)
        return area.area.shares(*on_cells(ends), rows, columns)

    wet = share_of(lake) > 0.0
    shore = _grown(wet, int(np.ceil(_SHORE_M / cell_m)))
    j, i = np.nonzero(~shore)
    longitude = np.asarray(first[0] + (i + 0.5) * (cell_m / x), dtype=np.float64)
    latitude = np.asarray(first[1] - (j + 0.5) * (cell_m / y), dtype=np.float64)
    never = np.zeros((rows, columns), dtype=bool)
    never[j, i] = ground(latitude.clip(-90.0, 90.0), longitude) < lake.level_m + _DRY_M
    for k, other in enumerate(lakes):
        a, b = other.area.bounds, lake.area.bounds
        if k != number and a[0] < b[2] + more_m / x and a[2] > b[0] - more_m / x and a[1] < b[3] and a[3] > b[1]:
            never |= (share_of(other) > 0.0) & ~wet
    for way in ways:
        c, r = (np.rint(v).astype(np.int64) for v in on_cells(way.points))
        on = (c >= 0) & (r >= 0) & (c < columns) & (r < rows) & (way.lake != number)
        mark = np.zeros((rows, columns), dtype=bool)
        mark[r[on], c[on]] = True
        if on.any():
            never |= _grown(mark, 1) & ~_grown(wet, 1)
    centres = [
        (first[0] + (a + 0.5) * (cell_m / x), first[1] - (b + 0.5) * (cell_m / y), r * cell_m)
        for a, b, r in _discs(np.argwhere(wet)[:, ::-1].astype(np.float64), np.argwhere(never)[:, ::-1])
    ]
    # A line of a metre each: as good as a point.
    flat = np.full(2, lake.level_m)
    return [(np.array([(a, b), (a, b - np.sign(b + 0.5) / y)]), flat, np.full(2, r), True) for a, b, r in centres]


def _grown(cells: NDArray[np.bool_], by: int) -> NDArray[np.bool_]:
    """These and those up to `by` cells away, to all sides."""
    for axis in (0, 1):
        total = np.cumsum(np.pad(cells.astype(np.int32), [(by + 1, by) if k == axis else (0, 0) for k in (0, 1)]), axis)
        size = cells.shape[axis]
        end = np.take(total, np.arange(2 * by + 1, 2 * by + 1 + size), axis)
        cells = end - np.take(total, np.arange(size), axis) > 0
    return cells


def _discs(wet: Floats, never: NDArray[np.int64]) -> list[tuple[float, float, float]]:
    """(x, y, radius) in cells: discs over all of wet (N, 2), and over as few of never (M, 2) as that many can."""

    def disc(part: Floats) -> tuple[int, tuple[float, float, float], Floats]:
        low, high = part.min(axis=0), part.max(axis=0)
        x, y = 0.5 * (low + high)
        radius = float(np.sqrt(((part - (x, y)) ** 2).sum(axis=1).max())) + 0.75
        bad = int((((never - (x, y)) ** 2).sum(axis=1) < radius * radius).sum())
        return bad, (float(x), float(y), radius), part

    first = disc(wet)
    heap, count, done = [(-first[0], 0, first)], 1, []
    while heap:
        bad, _, (_, found, part) = heapq.heappop(heap)
        if bad == 0 or len(part) < 4 or len(heap) + len(done) >= _MOST_ROUND:
            done.append(found)
            continue
        axis = int(np.argmax(np.ptp(part, axis=0)))
        middle = np.median(part[:, axis])
        left = part[:, axis] <= middle if (part[:, axis] > middle).any() else part[:, axis] < middle
        for half in (part[left], part[~left]):
            made = disc(half)
            heapq.heappush(heap, (-made[0], count, made))
            count += 1
    return done
