"""Rays against the ground, float64: stretches that ground can't reach are dropped, others halved, long ones first.

A stretch is free when both of its ends are clear of the ground by more than E, which bounds how far ground rises above
the line between them (ray_ground.py). All stretches of all rays of one length are looked at together, and only as
finely as that length asks for: heights gain layers and craters as stretches get shorter, where there still are any. Few
stretches are cut into more parts than two, since each look has its price.
What lies behind a place that is surely below the ground is never looked at. Compared with a bound on slopes alone (the
sphere tracing of Hart 1996), stretches grow faster than the clearance, because E doesn't grow like their length.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...engine.space import ray_sphere_from
from .crater_paths import CraterPaths, found_along
from .height import TerrainField
from .height_octaves import carved
from .height_surface import limit, side_rough
from .ray_ground import Detail, Kind, detail_of, ground_at, kinds, layers_at
from .ray_valleys import Cut, valley_rise

__all__ = ["raycast"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

_SMALLEST_M = 1e-3
_SMALLEST_SHARE = 1e-7
_ON_GROUND_M = 1e-8
"""Ten steps of a position on Earth in double precision."""
_WIDEST = 0.125
"""Stretches are at most so long by the planet's radius."""
_TOGETHER = 4096
"""Rays at once."""
_DOUBT = 0.1
"""A place that is so much of what has not been looked at below the ground is likely to be so in the end."""
_FEW = ((40, 4), (200, 2))
"""Up to so many stretches are halved so often before they are looked at."""
_SMOOTH = 0.25
"""Over so much of the finest layer's wavelength the ground is a parabola."""


def raycast(field: TerrainField, origins: Floats, directions: Floats, max_distance_m: Floats) -> tuple[Flags, Floats]:
    """First crossing of the ground along rays: hit (N,), distance_m (N,), inf where there is none.

    Rays start where they enter the shell between the bounds of the ground. Stretches of 1 mm (and 1e-7 of the way since
    then) are not halved again: a ray that grazes a crest may pass through less of it. A root is bracketed on a stretch
    where the clearance only falls, and then solved to less than a micrometre. An origin below the ground is a hit at
    distance 0.
    """
    top = ray_sphere_from(origins, directions, field.radius_m + field.highest_m)
    bottom = ray_sphere_from(origins, directions, field.radius_m + field.lowest_m)
    away = np.linalg.norm(origins, axis=1)
    outside = away > field.radius_m + field.highest_m
    near = np.where(outside, top.near_m, 0.0)
    end = np.minimum(np.where(outside, top.far_m, top.near_m), max_distance_m)
    # From above, the lowest ground is reached by then. (From below it the origin itself is a hit.)
    end = np.minimum(end, np.where(bottom.hit, bottom.near_m, np.inf))
    # Deeper than any ground nothing is searched: near the planet's centre no direction is up.
    hit = away < field.radius_m + field.lowest_m
    distance_m = np.where(hit, 0.0, np.inf)
    index = np.flatnonzero((top.hit | ~outside) & (near <= end) & (near <= max_distance_m) & ~hit)
    while index.size:
        later = []
        for start in range(0, len(index), _TOGETHER):
            at = index[start : start + _TOGETHER]
            search = _Search(field, origins[at], directions[at], near[at], end[at])
            search.run()
            hit[at], distance_m[at] = search.result()
            again = ~hit[at] & (search.doubtful < end[at])
            near[at[again]] = search.doubtful[again]
            later.append(at[again])
        index = np.concatenate(later)
    return hit, distance_m


class _Places:
    """Places on rays at which the ground is known, as arrays that are cut down together."""

    columns = ("ray", "t", "above", "base", "z", "furrows", "craters", "clearance", "kind", "feet", "cut")

    def __init__(self, kinds: int) -> None:
        self.ray = np.zeros(0, np.int64)
        self.feet, self.kind, self.cut = np.zeros((3, 0)), np.zeros((kinds, 0)), np.zeros((3, 0))
        for name in self.columns[1:-3]:
            setattr(self, name, np.zeros(0))

    t: Floats
    above: Floats
    """Height above the reference sphere."""
    base: Floats
    z: Floats
    furrows: Floats
    """What of z is gullies."""
    craters: Floats
    clearance: Floats

    def __len__(self) -> int:
        return len(self.ray)

    def take(self, which: Ints) -> None:
        for name in self.columns:
            setattr(self, name, getattr(self, name)[..., which])

    def add(self, other: _Places) -> None:
        for name in self.columns:
            setattr(self, name, np.concatenate([getattr(self, name), getattr(other, name)], axis=-1))


class _Search:
    """The rays of one batch. Stretches (S,) go from place `a` to place `b`, rows of `places`."""

    def __init__(self, field: TerrainField, origins: Floats, directions: Floats, near: Floats, end: Floats) -> None:
        self.field = field
        self.model, self.craters, self.rivers = field.model, field.model.craters, field.model.params.rivers
        self.origins, self.directions, self.near, self.end = origins, directions, near, end
        self.stretch = field.radius_m / (field.radius_m + min(field.lowest_m, 0.0))
        self.smooth_m = _SMOOTH * float(self.model.wavelength_m[-1])
        self.places = _Places(kinds(self.model))
        self.a, self.b = np.zeros(0, np.int64), np.zeros(0, np.int64)
        self.paths = CraterPaths.none()
        self.below = np.full(len(near), np.inf)
        """The first place that is known to be below the ground, of each ray."""
        self.doubtful = np.full(len(near), np.inf)
        """The first place that seems to be: what lies behind it is left for later, and seldom needed."""
        self.brackets: list[tuple[Ints, Floats, Floats, Floats, Floats]] = []

    def run(self) -> None:
        """Halves stretches until all are free or known to hold a crossing."""
        length = np.maximum(self.end - self.near, _SMALLEST_M)
        widest = _WIDEST * self.field.radius_m
        pieces = 2.0 ** np.maximum(np.ceil(np.log2(length / widest)), 0.0)
        level = np.ceil(np.log2(self.stretch * length / pieces)).astype(int)
        before: Detail | None = None
        now, halvings = int(level.max()), 1
        while now > -64:
            detail = detail_of(self.model, 2.0**now)
            roots = np.flatnonzero(level == now)
            if before is not None and len(self.a):
                self._refine(before, detail, 2**halvings)
            if len(roots):
                self._enter(roots, length[roots], pieces[roots].astype(np.int64), detail)
            before = detail
            if len(self.a):
                self._look(detail)
            elif now <= level.min():
                return
            later = level[level < now]
            halvings = min(self._halvings(), now - int(later.max()) if len(later) else 64)
            now -= halvings

    def _halvings(self) -> int:
        """How often stretches are halved before the next look: a look at few costs nearly as much as one at many."""
        if self.craters is not None:  # whose paths know of halves alone
            return 1
        return next((count for most, count in _FEW if len(self.a) <= most), 1)

    def _enter(self, rays: Ints, length: Floats, pieces: Ints, detail: Detail) -> None:
        """New stretches: rays (R,) in `pieces` (R,) equal parts."""
        ray = np.repeat(rays, pieces + 1)
        ends = np.cumsum(pieces + 1)
        k = np.arange(len(ray)) - np.repeat(ends - pieces - 1, pieces + 1)
        t = self.near[ray] + np.repeat(length / pieces, pieces + 1) * k
        first = len(self.places) + np.flatnonzero(k < np.repeat(pieces, pieces + 1))
        places = self._seen(ray, t, detail)
        self.places.add(places)
        old = len(self.a)
        self.a, self.b = np.concatenate([self.a, first]), np.concatenate([self.b, first + 1])
        self._find_craters(0, detail, slice(old, None))

    def _seen(self, ray: Ints, t: Floats, detail: Detail) -> _Places:
        """Places with their ground, but for craters."""
        found = _Places(kinds(self.model))
        p = (self.origins[ray] + t[:, None] * self.directions[ray]).T
        away = np.maximum(np.sqrt((p * p).sum(axis=0)), 1e-9)
        found.ray, found.t, found.above = ray, t, away - self.field.radius_m
        found.feet = p * (self.field.radius_m / away)
        found.base, found.z, found.furrows, found.kind, found.cut = ground_at(found.feet, detail)
        found.craters, found.clearance = np.zeros(len(t)), np.zeros(len(t))
        return found

    def _find_craters(self, octaves: int, detail: Detail, part: slice) -> None:
        """Craters of the octaves from `octaves` on that the detail looks at, along some of the stretches."""
        if self.craters is None or octaves == detail.octaves:
            return
        places, a, b = self.places, self.a[part], self.b[part]
        length = (places.t[b] - places.t[a]) * self.stretch
        found, height_a, height_b = found_along(
            self.craters, np.arange(octaves, detail.octaves), (places.feet[:, a], places.feet[:, b]), length
        )
        added = np.zeros(len(places))
        added[a], added[b] = height_a, height_b  # neighbours agree on what they share
        places.craters += added
        found.names[0] += part.start or 0
        self.paths = self.paths.joined(found)

    def _refine(self, before: Detail, detail: Detail, parts: int) -> None:
        """Cuts all stretches into parts (with craters, two), and looks at all places as the detail does."""
        places = self.places
        share = np.arange(1, parts) / parts
        ray = np.repeat(places.ray[self.a], parts - 1)
        first = places.t[self.a, None]
        t = (first + share * (places.t[self.b, None] - first)).ravel()
        middle = self._seen(ray, t, detail)
        if detail.layers > before.layers:
            places.z += layers_at(places.feet, before, detail)
        count = len(self.a)
        if self.craters is not None:
            length = (places.t[self.b] - t) * self.stretch
            self.paths, middle.craters = self.paths.halves(self.craters, middle.feet, length, count)
        new = len(places) + np.arange(count * (parts - 1)).reshape(count, -1)
        places.add(middle)
        a, b = self.a[:, None], self.b[:, None]
        self.a, self.b = np.hstack([a, new]).ravel(), np.hstack([new, b]).ravel()
        self._find_craters(before.octaves, detail, slice(0, None))

    def _look(self, detail: Detail) -> None:
        """Drops stretches that are free, or behind the first place below the ground; keeps brackets."""
        places = self.places
        rough = places.kind[Kind.ROUGH]
        ground = places.base + rough * (places.z + detail.mean_m) + places.craters
        ground = limit(self.model.constants, ground)
        there = ground
        kind = places.kind
        if self.rivers is not None:
            base, left, raised = places.cut
            there = carved(ground, base, left, raised, places.furrows)
            if self.model.gullied:
                kind = kind.copy()
                kind[Kind.ROUGH] += side_rough(ground, base, left)
        places.clearance = places.above - there
        rest = rough * detail.rest_m + detail.craters_down_m
        sunk = np.flatnonzero(places.clearance <= -_DOUBT * rest)
        on_way = sunk[places.t[sunk] > self.near[places.ray[sunk]]]
        np.minimum.at(self.doubtful, places.ray[on_way], places.t[on_way])
        sunk = sunk[places.clearance[sunk] <= -rest[sunk]]
        np.minimum.at(self.below, places.ray[sunk], places.t[sunk])
        a, b = self.a, self.b
        before = places.t[a] < np.minimum(self.doubtful, self.below)[places.ray[a]]
        length = places.t[b] - places.t[a]
        reach = length * self.stretch
        own = kind[: len(Kind)]
        rise = detail.rise(reach, np.maximum(own[:, a], own[:, b]))
        if self.craters is not None:
            rise += self.paths.rise(self.craters, reach)
        if self.rivers is not None:
            cut_m, (base_m, left, _) = np.abs(ground - there), places.cut
            ends = Cut(ground - base_m, base_m, left, cut_m, kind[len(Kind) :])
            rise += valley_rise(ends.at(a), ends.at(b), reach, rise, self.rivers.steepest_per_m)
        ca, cb = places.clearance[a], places.clearance[b]
        keep = before & (np.minimum(ca, cb) < rise)
        if detail.whole:
            small = length <= np.maximum(_SMALLEST_M, _SMALLEST_SHARE * (places.t[a] - self.near[places.ray[a]]))
            # A deviation that is a parabola has slopes of at most four times its height by the length.
            settled = small | ((length <= self.smooth_m) & (np.abs(ca - cb) > 4.0 * rise))
            new = keep & settled & (ca > 0.0) & (cb <= 0.0)
            if new.any():
                self.brackets.append((places.ray[a][new], places.t[a][new], places.t[b][new], ca[new], cb[new]))
            keep &= ~settled
        self._keep(np.flatnonzero(keep))

    def _keep(self, which: Ints) -> None:
        number = np.full(len(self.a), -1)
        number[which] = np.arange(len(which))
        if len(self.paths):
            self.paths = self.paths.renumbered(number)
        a, b = self.a[which], self.b[which]
        used = np.zeros(len(self.places), bool)
        used[a] = used[b] = True
        place = np.cumsum(used) - 1
        self.places.take(np.flatnonzero(used))
        self.a, self.b = place[a], place[b]

    def result(self) -> tuple[Flags, Floats]:
        """Hit (R,) and distance (R,) of all rays."""
        distance = np.where(self.below <= self.near, self.near, np.inf)  # buried
        if self.brackets:
            ray, above, under, ca, cb = (np.concatenate(part) for part in zip(*self.brackets, strict=True))
            order = np.lexsort((above, ray))
            first = order[np.unique(ray[order], return_index=True)[1]]
            first = first[np.isinf(distance[ray[first]])]
            ray = ray[first]
            distance[ray] = _solve(
                self.field, self.origins[ray], self.directions[ray], above[first], under[first], ca[first], cb[first]
            )
        distance = np.where(distance <= self.end, distance, np.inf)
        return np.isfinite(distance), distance


def _solve(
    field: TerrainField, origins: Floats, directions: Floats, a: Floats, b: Floats, fa: Floats, fb: Floats
) -> Floats:
    """Distances where rays cross the ground between `a` and `b`, where they are `fa` above it and `fb` (at most 0):
    Illinois false position."""
    result = b.copy()
    at, side = np.arange(len(a)), np.zeros(len(a))
    for _ in range(60):
        if not at.size:
            break
        middle = np.clip(a + (b - a) * fa / np.where(fa - fb > 0.0, fa - fb, 1.0), a, b)
        p = origins[at] + middle[:, None] * directions[at]
        away = np.linalg.norm(p, axis=1)
        f = away - field.radius_m - field.height(p / away[:, None])
        up = f > 0.0
        # The end that stays a second time counts for half, so that it moves as well.
        fb, fa = np.where(up, np.where(side > 0, 0.5 * fb, fb), f), np.where(up, f, np.where(side < 0, 0.5 * fa, fa))
        side = np.where(up, 1.0, -1.0)
        a, b = np.where(up, middle, a), np.where(up, b, middle)
        done = (b - a < 1e-7) | (np.abs(f) < _ON_GROUND_M)
        result[at] = np.where(np.abs(f) < _ON_GROUND_M, middle, b)
        at = at[~done]
        side, a, b, fa, fb = (v[~done] for v in (side, a, b, fa, fb))
    return result
