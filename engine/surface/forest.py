"""Which tiles to draw: a forest of cells whose ground is split by its measured error in pixels.

A node's error in pixels is its measured geometric error over the nearest distance of its hull, over the angle of a
pixel. A node is split where that is more than what is wanted; children never count for more than 1 / STEP of their
parent. A split node needs its supports split (nodes.py), which keeps neighbours within one level: they count for at
least STEP times as much as it.

Nothing jumps: children appear as their parent looked (morph 1) and become themselves (morph 0) while the parent's error
grows from the wanted one to BAND times it, and not faster than in MORPH_S. A node is split, or merged, only while the
edges around it are at rest. What is far from its threshold (by HURRY), or a first call, doesn't wait. Once nothing has
changed for REST_S the selection is a function of eye, facts and limits alone.

All is done in numpy over all nodes at once. The selection doesn't depend on where the camera looks.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .keys import NO_NODE, children_of, container_of, level_of
from .nodes import GIVEN, UNKNOWN, NodeTable
from .scheme import Scheme

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]

BAND = 1.25
"""Children are themselves from this many times the wanted error of their parent on."""
HOLD = 1.1
"""A split node is merged when its error has fallen below the wanted one over this."""
STEP = BAND * HOLD
"""By how much a node's supports count for more than it: they are at rest when it may be split."""
HURRY = 4.0
"""Errors so many times too large, or small, are mended at once."""
MORPH_S = 0.1
"""A whole morph takes at least this long."""
REST_S = 0.3
"""After this long without change nothing is held or morphed any more."""
MORPH_STEPS = 64
"""Morph factors are multiples of 1 / 64, so that most stay the same from frame to frame."""
FADE = 0.15
"""Errors fade to nothing over this part of the angle to the horizon, beyond it."""
FINER_ERROR = 0.5
"""The error of an unknown child as a fraction of its parent's."""
MAX_WANTED = 256


@dataclass(frozen=True, eq=False)
class NodeFacts:
    """What is measured of a node's ground, (N,) each; heights above the reference sphere in metres."""

    low_m: Floats
    high_m: Floats
    error_m: Floats
    """Largest distance of the true ground from the node's mesh."""


@dataclass(frozen=True, eq=False)
class Selection:
    """Tiles to draw, nearest first, and tiles to make. Arrays have N rows and are not to be written."""

    keys: Ints
    """(N,)."""
    morph: NDArray[np.float32]
    """(N,): 1 as the parent looks, 0 as the tile itself does."""
    edge_skip: NDArray[np.uint8]
    """(N, E): by how many levels the neighbour is coarser; vertices are rounded down to multiples of 2^skip."""
    edge_morph: NDArray[np.float32]
    """(N, E): the morph of an edge; the same for both tiles of one level, 0 where levels differ."""
    distance_m: Floats
    """(N,), to the nearest point of the tile's hull."""
    wanted: Ints
    """(M,): tiles to make, most urgent first, parents before children."""
    moving: bool
    """Whether morphs still run, or would if time went on."""
    revision: int
    """Grows when keys, skips or morphs change."""
    error_px: float
    """The error that was allowed: the wanted one, or more to stay within max_tiles."""
    levels: Ints = field(default_factory=lambda: np.zeros(0, np.int64))
    """(N,)."""

    def __len__(self) -> int:
        return len(self.keys)


class _Active(NamedTuple):
    """The nodes that are looked at, copied together; rows 0 and 1 as in the table."""

    rows: Ints
    supports: Ints
    kids_known: Mask
    low: Floats
    high: Floats
    error: Floats
    center: Floats
    reach: Floats
    normals: Floats
    horizon: Floats


class Forest:
    """Selects tiles of a scheme on a planet.

    Parameters: `scheme`; `radius_m` of the reference sphere; `lowest_m`, `highest_m`: bounds of all ground;
    `segments` of a tile's side; `occluder_m`: height of the sphere that hides what is behind it, the lowest ground if
    None (give the sea's level where the sea is opaque); `metric`: "error", or "distance" to split by
    `split_distance_m`, (levels,): a node of level L is split while it is nearer; `balanced`: neighbours differ by one
    level at most when drawn.
    """

    def __init__(
        self,
        scheme: Scheme,
        radius_m: float,
        lowest_m: float,
        highest_m: float,
        segments: int = 32,
        occluder_m: float | None = None,
        metric: str = "error",
        split_distance_m: ArrayLike | None = None,
        balanced: bool = True,
    ) -> None:
        if not (np.isfinite([radius_m, lowest_m, highest_m]).all() and radius_m + lowest_m > 0 and radius_m > 0):
            raise ValueError(
                "Forest: expected a positive radius_m and finite heights above the centre, found "
                f"radius_m={radius_m!r}, lowest_m={lowest_m!r}, highest_m={highest_m!r}"
            )
        if segments < 2 or segments & (segments - 1):
            raise ValueError(f"Forest: segments must be a power of two, at least 2, found {segments!r}")
        if metric not in ("error", "distance") or (metric == "distance") != (split_distance_m is not None):
            raise ValueError(
                'Forest: metric must be "error", or "distance" with split_distance_m, found '
                f"metric={metric!r}, split_distance_m={split_distance_m!r}"
            )
        self.scheme = scheme
        self.radius_m = float(radius_m)
        self.lowest_m, self.highest_m = float(lowest_m), float(highest_m)
        self.segments = segments
        occluder = lowest_m if occluder_m is None else occluder_m
        self._occluder_r = self.radius_m + float(occluder)
        self.split_distance_m = None if split_distance_m is None else np.asarray(split_distance_m, dtype=np.float64)
        self.table = NodeTable(scheme, balanced)
        self._call = 0
        self._revision = 0
        self._changed = True
        self._time_s: float | None = None
        self._still_since_s: float | None = None
        self._asked: tuple[object, ...] = ()
        self._all = True
        self._active: _Active | None = None
        self._selection: Selection | None = None

    # -- facts --------------------------------------------------------------------------------------------------------

    def set_facts(self, keys: ArrayLike, low_m: ArrayLike, high_m: ArrayLike, error_m: ArrayLike) -> None:
        """Make nodes known: tiles that can be drawn. Arrays (N,), or numbers for all; known nodes get new facts."""
        keys = np.asarray(keys, dtype=np.int64).ravel()
        low, high, error = (
            np.broadcast_to(np.asarray(a, dtype=np.float64), keys.shape) for a in (low_m, high_m, error_m)
        )
        if not (np.isfinite(low).all() and np.isfinite(high).all() and (low <= high).all() and (error >= 0.0).all()):
            raise ValueError("set_facts: heights must be finite with low_m <= high_m, and error_m must not be negative")
        if (keys <= NO_NODE).any():
            raise ValueError("set_facts: 0 and negative numbers name no node")
        self.table.add(keys, low, high, error)
        self._changed = True

    def forget(self, keys: ArrayLike) -> None:
        """Nodes can't be drawn any more; their parents will be, if need be."""
        self.table.remove(np.asarray(keys, dtype=np.int64).ravel())
        self._changed = True

    def knows(self, keys: ArrayLike) -> Mask:
        """Which nodes are known."""
        return self.table.find(np.asarray(keys, dtype=np.int64)) > UNKNOWN

    def facts(self, keys: ArrayLike) -> NodeFacts:
        """The facts of known nodes. Raises KeyError for others."""
        rows = self.table.find(np.asarray(keys, dtype=np.int64))
        if (rows <= UNKNOWN).any():
            raise KeyError("Forest.facts: unknown node")
        return NodeFacts(self.table.low_m[rows], self.table.high_m[rows], self.table.error_m[rows])

    def droppable(self, count: int) -> Ints:
        """Up to `count` known nodes that may be forgotten, those of no use for longest first. Roots stay."""
        table = self.table
        rows = np.flatnonzero(table.known & (table.used < self._call) & (table.level > 0))
        order = np.lexsort((-table.level[rows], table.used[rows]))
        return table.key[rows[order[:count]]]

    def leaves(self) -> Ints:
        """All leaves of the last selection, sorted, hidden ones too: they cover the sphere once all roots are known."""
        table = self.table
        drawn = table.known & ~table.split & table.split[table.supports[:, 0]]
        return np.sort(table.key[drawn])

    # -- selection ----------------------------------------------------------------------------------------------------

    def select(
        self,
        eye_m: ArrayLike,
        pixel_rad: float,
        error_px: float,
        time_s: float | None = None,
        velocity_m_s: ArrayLike | None = None,
        finest_spacing_m: float = 0.05,
        max_tiles: int = 4096,
    ) -> Selection:
        """Tiles for an eye (3,), planet-centred metres; `pixel_rad` is the angle of a pixel.

        `time_s` runs the morphs; None finishes them at once. `velocity_m_s` (3,) is for what to make in advance.
        Raises ValueError for an eye that isn't finite or is at the centre, and for limits that are not positive.
        """
        eye = np.asarray(eye_m, dtype=np.float64)
        if eye.shape != (3,) or not np.isfinite(eye).all() or not eye.any():
            raise ValueError(f"Forest.select: expected a finite eye_m (3,) away from the centre, found {eye_m!r}")
        for name, value in (("pixel_rad", pixel_rad), ("error_px", error_px), ("finest_spacing_m", finest_spacing_m)):
            if not (np.isfinite(value) and value > 0):
                raise ValueError(f"Forest.select: {name} must be positive and finite, found {value!r}")
        asked = (*eye.tolist(), pixel_rad, error_px, finest_spacing_m, max_tiles)
        still = asked == self._asked and not self._changed
        self._call += 1
        step_s, rested = self._clock(time_s, still)
        if still and self._selection is not None and not self._selection.moving:
            return self._selection
        self._asked, self._changed = asked, False
        first = self._selection is None
        del max_tiles, velocity_m_s, first
        return self._run(eye, pixel_rad, error_px, finest_spacing_m, step_s, rested)

    def _clock(self, time_s: float | None, still: bool) -> tuple[float, bool]:
        """Seconds since the last call, infinite where morphs are to be finished; and whether all is at rest."""
        if time_s is None:
            self._time_s = self._still_since_s = None
            return np.inf, True
        step_s = np.inf if self._time_s is None else max(time_s - self._time_s, 0.0)
        self._time_s = time_s
        if not still or self._still_since_s is None:
            self._still_since_s = time_s
        return step_s, time_s - self._still_since_s >= REST_S

    def _gather(self) -> _Active:
        table = self.table
        rows = np.concatenate([[GIVEN, UNKNOWN], np.flatnonzero(table.known)])
        place = np.full(len(table.known), UNKNOWN, np.int64)
        place[rows] = np.arange(len(rows))
        high = self.radius_m + table.high_m[rows]
        spacing = self.scheme.spacing_rad(table.level[rows], self.segments)
        # The mesh's chords hang below the ground that they stand for.
        low = (self.radius_m + table.low_m[rows]) * (1.0 - spacing**2 / 8.0)
        above = np.maximum(high - self._occluder_r, 0.0) / self._occluder_r
        return _Active(
            rows,
            place[table.supports[rows]],
            (table.kids[rows] > UNKNOWN).all(axis=1),
            low,
            high,
            table.error_m[rows],
            table.center[rows],
            table.reach[rows],
            table.normals[rows].reshape(-1, 3),
            np.arctan(np.sqrt(above * (2.0 + above))),
        )

    def _measure(self, nodes: _Active, eye: Floats, floor_m: float) -> tuple[Floats, Floats]:
        """Distances to the nodes' hulls, and how much of an error counts: 1, less beyond the horizon."""
        away = float(np.sqrt(eye @ eye))
        up = eye / away
        offset = nodes.center - up
        chord = np.sqrt(np.einsum("nk,nk->n", offset, offset)) - nodes.reach
        beyond = -(nodes.normals @ up).reshape(len(chord), -1).min(axis=1)
        beyond = np.clip(beyond, 0.0, 1.0)
        # A chord from the sine of its angle; both are lower bounds of the chord to the nearest point.
        chord2 = np.maximum(np.maximum(chord, 0.0) ** 2, 2.0 * beyond**2 / (1.0 + np.sqrt(1.0 - beyond**2)))
        height = np.clip(away * (1.0 - 0.5 * chord2), nodes.low, nodes.high)
        distance = np.sqrt((away - height) ** 2 + away * height * chord2)
        above = (away - self._occluder_r) / self._occluder_r
        if above <= 0.0:
            return np.maximum(distance, floor_m), np.ones(len(chord))
        limit = nodes.horizon + np.arctan(np.sqrt(above * (2.0 + above)))
        angle = 2.0 * np.arcsin(np.minimum(0.5 * np.sqrt(chord2), 1.0))
        return np.maximum(distance, floor_m), np.clip(1.0 - (angle / limit - 1.0) / FADE, 0.0, 1.0)

    def _run(
        self, eye: Floats, pixel_rad: float, error_px: float, finest_spacing_m: float, step_s: float, rested: bool
    ) -> Selection:
        nodes = self._gather()
        table = self.table
        distance, counts = self._measure(nodes, eye, finest_spacing_m)
        level = table.level[nodes.rows]
        error = nodes.error
        if self.split_distance_m is not None:
            reach = self.split_distance_m
            error = np.where(level < len(reach), reach[np.minimum(level, len(reach) - 1)], 0.0) * pixel_rad * error_px
        finest = self.radius_m * self.scheme.spacing_rad(level, self.segments) <= finest_spacing_m
        finest |= level >= self.scheme.finest_level - (self.segments.bit_length() - 1)
        found = np.where(finest, 0.0, error * counts / (distance * pixel_rad)) / error_px
        found[GIVEN], found[UNKNOWN] = np.inf, 0.0
        split = table.split[nodes.rows]
        share = _saturated(found, nodes.supports, split, 1.0 if rested else 1.0 / HOLD)
        split, morph, moving = self._step(nodes, share, split, step_s, rested)
        drawn = split[nodes.supports[:, 0]] & ~split
        drawn[:2] = False
        table.used[nodes.rows[split[nodes.supports[:, 0]]]] = self._call
        wanted = self._wanted(nodes, share, drawn)
        return self._finish(nodes, distance, counts, drawn, morph, wanted, moving, error_px)

    def _step(
        self, nodes: _Active, share: Floats, split: Mask, step_s: float, rested: bool
    ) -> tuple[Mask, Floats, bool]:
        """Split and merge nodes, and move morphs on."""
        table, supports = self.table, nodes.supports
        morph = table.morph[nodes.rows]
        split = _closed(split & nodes.kids_known, supports)
        want = (share > 1.0) | (split & (share > (1.0 if rested else 1.0 / HOLD)))
        want = _closed(want & nodes.kids_known, supports)
        goal = np.clip((BAND - share) / (BAND - 1.0), 0.0, 1.0)
        goal[~want] = 1.0
        if rested or not np.isfinite(step_s):
            new, morph = want, goal
            moving = False
        else:
            ready = (split[supports] & (morph[supports] == 0.0)).all(axis=1) | (share > HURRY)
            new = split | (want & ready)
            held = np.zeros(len(new), bool)
            held[supports[new]] = True
            goal[held] = 0.0
            far = (share > HURRY) | (share < 1.0 / HURRY)
            morph = np.where(far, goal, morph + np.clip(goal - morph, -step_s / MORPH_S, step_s / MORPH_S))
            done = ~want & (((morph == 1.0) & ~held) | (share < 1.0 / HURRY))
            new &= ~done
            moving = bool((new != want).any() or (morph != goal)[new].any())
        new[GIVEN], new[UNKNOWN] = True, False
        morph = np.where(new, morph, 1.0)
        morph[GIVEN] = 0.0
        table.split[nodes.rows], table.morph[nodes.rows] = new, morph
        return new, morph, moving

    def _wanted(self, nodes: _Active, share: Floats, drawn: Mask) -> Ints:
        table = self.table
        roots = self.scheme.root_keys()
        missing = roots[table.find(roots) == UNKNOWN]
        short = np.flatnonzero(drawn & (share > 1.0) & ~nodes.kids_known)
        short = short[np.argsort(-share[short], kind="stable")][:MAX_WANTED]
        children = children_of(table.key[nodes.rows[short]])
        have = table.kids[nodes.rows[short]]
        table.used[have[have > UNKNOWN]] = self._call
        return np.concatenate([missing, children[have == UNKNOWN]])[:MAX_WANTED]

    def _finish(
        self,
        nodes: _Active,
        distance: Floats,
        counts: Floats,
        drawn: Mask,
        morph: Floats,
        wanted: Ints,
        moving: bool,
        error_px: float,
    ) -> Selection:
        table = self.table
        morph = np.rint(morph * MORPH_STEPS) / MORPH_STEPS
        leaves = np.flatnonzero(drawn)
        keys = table.key[nodes.rows[leaves]]
        order = np.argsort(keys)
        leaves, keys = leaves[order], keys[order]
        own = morph[nodes.supports[leaves, 0]]
        level = level_of(keys)
        beside = table.neighbour_keys[nodes.rows[leaves]]
        at = container_of(beside, keys)
        coarser = np.where(at >= 0, level[:, None] - level[at], 0)
        same = (at >= 0) & (coarser == 0)
        edge = np.where(same, np.maximum(own[:, None], own[at]), 0.0)
        seen = np.flatnonzero(counts[leaves] > 0.0)
        seen = seen[np.argsort(distance[leaves[seen]], kind="stable")]
        last = self._selection
        result = (
            keys[seen],
            own[seen].astype(np.float32),
            coarser[seen].astype(np.uint8),
            edge[seen].astype(np.float32),
        )
        if last is None or not all(
            np.array_equal(a, b)
            for a, b in zip(result, (last.keys, last.morph, last.edge_skip, last.edge_morph), strict=True)
        ):
            self._revision += 1
        self._selection = Selection(
            *result, distance[leaves[seen]], wanted, moving, self._revision, error_px, level[seen]
        )
        return self._selection


def _saturated(found: Floats, supports: Ints, split: Mask, hold: float) -> Floats:
    """Errors as multiples of the wanted one, so that children count for less than their parents, and the supports of
    nodes that are to be split count for more than these."""
    share = found
    while True:
        capped = np.minimum(share, share[supports[:, 0]] / STEP)
        capped[GIVEN] = np.inf
        if np.array_equal(capped, share):
            break
        share = capped
    while True:
        above = np.flatnonzero((share > 1.0) | (split & (share > hold)))
        least = np.broadcast_to((STEP * share[above])[:, None], (len(above), supports.shape[1]))
        to = supports[above]
        less = share[to] < least
        less &= to > UNKNOWN
        if not less.any():
            return share
        share = share.copy()
        np.maximum.at(share, to[less], least[less])


def _closed(split: Mask, supports: Ints) -> Mask:
    """The largest part of a set of nodes whose supports belong to it."""
    split = split.copy()
    split[GIVEN], split[UNKNOWN] = True, False
    while True:
        inside = np.flatnonzero(split)
        lost = inside[~split[supports[inside]].all(axis=1)]
        if not len(lost):
            return split
        split[lost] = False
