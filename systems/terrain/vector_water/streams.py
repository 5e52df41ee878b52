"""Rivers of a vector map: levels that never rise downstream, and as few lines as show them.

Ways that share a place are joined there, and a lake is one place to all that come to it. Each place is as high as the
lowest of its own ground and of all that lies upstream (in loops: in the order in which they are found).
"""

from __future__ import annotations

import heapq
import logging
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ....engine.real_ground.polygons import Polygons
from ....engine.real_ground.vector_file import Course, Patch
from .bodies import Body, Ground, metres_per_deg

__all__ = ["Way", "levelled", "simplified", "widened"]

log = logging.getLogger(__name__)

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_APART_M = 60.0
"""Places along a way are no farther from each other."""
_MOST_PLACES = 400_000
_UPHILL_M = 5.0
"""A way that ends so much higher than it begins was drawn upstream."""
_BELOW_BANK_M = 0.3
"""Water lies so far below the ground that it runs through."""
_STEEP = 2.0
"""A metre of level counts as so many along the ground where places are left out."""


@dataclass(eq=False)
class Way:
    """Places (N, 2) downstream, longitude and latitude in degrees. lake: index of the lake that each lies in, -1;
    fixed: where others join, and which lines may not leave out."""

    points: Floats
    half_m: Floats
    level_m: Floats
    lake: Ints
    fixed: NDArray[np.bool_]


def widened(courses: Sequence[Course], banks: Sequence[Patch], radius_m: float) -> tuple[list[Floats], list[Patch]]:
    """Half widths (N,) of each course at its points: stated ones, else the distance to the banks that it runs between,
    else the default. And the banks that no course runs between."""
    found, left = [np.full(len(c.points), 0.5 * c.width_m) for c in courses], []
    for patch in banks:
        area, used = Polygons(patch.polygons), False
        for course, half in zip(courses, found, strict=True):
            at = np.flatnonzero(area.inside(*course.points.T))
            used |= bool(at.size)
            if not course.stated and at.size:
                x, y = metres_per_deg(radius_m, float(course.points[at[0], 1]))
                half[at] = np.maximum(half[at], _distances(course.points[at], area.edges, x, y))
        if not used:
            left.append(patch)
    return found, left


def _distances(points: Floats, edges: Floats, x: float, y: float) -> Floats:
    """(N,) m to the nearest of edges. x, y: metres of a degree."""
    a, b = edges[:, :2] * (x, y), edges[:, 2:] * (x, y)
    way = b - a
    square = np.maximum((way * way).sum(axis=1), 1e-9)
    found = np.empty(len(points))
    for k, point in enumerate(points * (x, y)):
        t = np.clip(((point - a) * way).sum(axis=1) / square, 0.0, 1.0)
        found[k] = np.sqrt((((point - a) - t[:, None] * way) ** 2).sum(axis=1).min())
    return found


def levelled(
    courses: Sequence[Course], halves: Sequence[Floats], lakes: Sequence[Body], ground: Ground, radius_m: float
) -> list[Way]:
    """Ways with their levels; those of lakes sink to what comes into them."""
    if not courses:
        return []
    apart_deg = float(np.degrees(_APART_M / radius_m))
    total_deg = sum(float(np.abs(np.diff(c.points, axis=0)).sum()) for c in courses)
    apart_deg = max(apart_deg, total_deg / _MOST_PLACES)
    parts = [_dense(c.points, half, apart_deg) for c, half in zip(courses, halves, strict=True)]
    points = np.concatenate([p for p, _ in parts])
    ends = np.cumsum([0, *(len(p) for p, _ in parts)])
    own = ground(points[:, 1], points[:, 0]) - _BELOW_BANK_M
    lake = np.full(len(points), -1)
    for number, body in enumerate(lakes):
        west, south, east, north = body.area.bounds
        near = np.flatnonzero((points[:, 1] >= south) & (points[:, 1] <= north))
        if west >= -180.0 and east <= 180.0:
            near = near[(points[near, 0] >= west) & (points[near, 0] <= east)]
        lake[near[body.area.inside(*points[near].T)]] = number
    # Equal places have one number, and so has a lake.
    wrapped = np.rint(np.stack([np.mod(points[:, 0], 360.0), points[:, 1]], axis=1) * 1e7).astype(np.int64)
    _, name = np.unique(wrapped, axis=0, return_inverse=True)
    name = np.where(lake >= 0, lake, len(lakes) + name.ravel())
    order = []
    for a, b in pairwise(ends.tolist()):
        at = np.arange(a, b)
        order.append(at[::-1] if own[b - 1] > own[a] + _UPHILL_M else at)
    level = np.full(int(name.max()) + 1, np.inf)
    np.minimum.at(level, name, np.where(lake >= 0, np.inf, own))
    for number, body in enumerate(lakes):
        level[number] = body.level_m
    _sink(level, [name[at] for at in order])
    for number, body in enumerate(lakes):
        body.level_m = float(level[number])
    many = np.bincount(np.concatenate([np.unique(name[at]) for at in order]), minlength=len(level))
    half = np.concatenate([h for _, h in parts])
    found = []
    for at in order:
        fixed = many[name[at]] > 1
        fixed[[0, -1]] = True
        fixed[1:] |= lake[at][1:] != lake[at][:-1]
        fixed[:-1] |= lake[at][1:] != lake[at][:-1]
        found.append(Way(points[at], half[at], level[name[at]], lake[at], fixed))
    return found


def _dense(points: Floats, half: Floats, apart_deg: float) -> tuple[Floats, Floats]:
    step = np.diff(points, axis=0)
    many = np.maximum(np.ceil(np.hypot(*step.T) / apart_deg), 1.0).astype(np.int64)
    edge = np.repeat(np.arange(len(step)), many)
    share = (np.arange(len(edge)) - np.repeat(np.cumsum(many) - many, many)) / many[edge]
    between = points[edge] + share[:, None] * step[edge]
    wide = half[edge] + share * np.diff(half)[edge]
    return np.concatenate([between, points[-1:]]), np.append(wide, half[-1])


def _sink(level: Floats, ways: Sequence[Ints]) -> None:
    """Levels of places, each at most that of all from which a way leads to it."""
    a = np.concatenate([w[:-1] for w in ways])
    b = np.concatenate([w[1:] for w in ways])
    a, b = a[a != b], b[a != b]
    order = np.argsort(a, kind="stable")
    after, begin = b[order].tolist(), np.searchsorted(a[order], np.arange(len(level) + 1)).tolist()
    missing = np.bincount(b, minlength=len(level)).tolist()
    values, done = level.tolist(), [False] * len(level)
    ready = [k for k, count in enumerate(missing) if count == 0]
    rest = [(-v, k) for k, v in enumerate(values)]
    heapq.heapify(rest)
    while True:
        while ready:
            k = ready.pop()
            if done[k]:
                continue
            done[k] = True
            for to in after[begin[k] : begin[k + 1]]:
                values[to] = min(values[to], values[k])
                missing[to] -= 1
                if missing[to] <= 0 and not done[to]:
                    ready.append(to)
        # A loop: its highest place goes first.
        while rest and done[rest[0][1]]:
            heapq.heappop(rest)
        if not rest:
            break
        ready.append(heapq.heappop(rest)[1])
    level[:] = values


def simplified(way: Way, tolerance_m: float, radius_m: float) -> Ints:
    """Indices of the places that a line needs to stay within tolerance_m of them all (Douglas and Peucker 1973), a
    part of their widths where that is more."""
    x, y = metres_per_deg(radius_m, float(way.points[:, 1].mean()))
    places = np.concatenate([way.points * (x, y), _STEEP * way.level_m[:, None]], axis=1)
    allowed = np.maximum(tolerance_m, 0.1 * way.half_m)
    kept = way.fixed.copy()
    spans = list(pairwise(np.flatnonzero(kept).tolist()))
    while spans:
        a, b = spans.pop()
        if b - a < 2:
            continue
        line, off = places[b] - places[a], places[a + 1 : b] - places[a]
        t = np.clip(off @ line / max(float(line @ line), 1e-12), 0.0, 1.0)
        away = np.sqrt(((off - t[:, None] * line) ** 2).sum(axis=1)) / allowed[a + 1 : b]
        worst = int(np.argmax(away))
        if away[worst] > 1.0:
            kept[a + 1 + worst] = True
            spans += [(a, a + 1 + worst), (a + 1 + worst, b)]
    return np.flatnonzero(kept)
