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

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .chosen import NodeFacts, Selection
from .hulls import Hulls, Walked, tangent_length, visible_share, walk_frustum
from .keys import MAX_LEVEL, NO_NODE, container_of
from .nodes import GIVEN, UNKNOWN, NodeTable
from .refinement import HOLD, STEP, capped, closed, goals, step, wanted_split
from .scheme import Scheme
from .wanted import Foresight, Known

__all__ = ["Forest", "NodeFacts", "Selection"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]

REST_S = 0.3
"""After this long without change nothing is held or morphed any more."""
MORPH_STEPS = 64
"""Morph factors are multiples of 1 / 64, so that most stay the same from frame to frame."""
SLACK = 1.0 / 512.0
"""Eyes that moved by less than this part of the nearest tile's distance get the same selection, until they rest."""
BUDGET_STEPS = 16
"""With too many tiles the allowed error grows in steps of 2^(1/16)."""


class _Asked(NamedTuple):
    """What the weights of nodes depend on."""

    pixel_rad: float
    error_px: float
    finest_spacing_m: float
    spacing_px: float | None


class _Leaves(NamedTuple):
    """The leaves, sorted by key, and what lies across their edges."""

    rows: Ints
    parents: Ints
    """Rows."""
    keys: Ints
    level: Ints
    skip: NDArray[np.uint8]
    beside: Ints
    """(N, E): the leaf of the same level across each edge; where there is none, the leaf itself."""
    same: NDArray[np.float32]
    """(N, E): 1 or 0."""


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
        self._spacing_m = self.radius_m * scheme.spacing_rad(np.arange(MAX_LEVEL + 1), segments)
        self.balanced = balanced
        self.table = NodeTable(scheme, balanced)
        self._call = 0
        self._revision = 0
        self._changed = True  # facts
        self._time_s: float | None = None
        self._still_since_s: float | None = None
        self._asked: tuple[_Asked, int] | None = None
        self._eye: Floats | None = None  # of the last evaluation
        self._last_eye: Floats | None = None  # of the last call
        self._slack_m = 0.0
        self._budget_step = 0
        self._final = False  # whether the last evaluation was of an eye at rest
        self._kids_known: Mask = np.zeros(0, bool)
        self.hulls = Hulls(*(np.zeros(0) for _ in range(5)))
        self._leaves: _Leaves | None = None
        self._weighed: _Asked | None = None
        self._weights: Floats = np.zeros(0)
        self._missing_roots: Ints = scheme.root_keys()
        self._foresight = Foresight(self.table, self._occluder_r)
        self._drawn: Mask = np.zeros(0, bool)
        self._selection: Selection | None = None
        self._order: Ints = np.zeros(0, np.int64)
        self._seen: Ints = np.zeros(0, np.int64)
        self._morphs: NDArray[np.float32] = np.zeros(0, np.float32)
        self._parents: Ints = np.zeros(0, np.int64)
        self.lacking = 0
        """Leaves of the last selection that are coarser than wanted, because their children are not known."""
        self.evaluations = 0
        """Counts the calls that looked at nodes."""

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
        table = self.table
        rows = table.add(keys, low, high, error)
        # The mesh's chords hang below the ground that they stand for.
        sag = 1.0 - self.scheme.spacing_rad(table.level[rows], self.segments) ** 2 / 8.0
        table.low[rows], table.high[rows] = (self.radius_m + low) * sag, self.radius_m + high
        table.tangent[rows] = tangent_length(table.high[rows], self._occluder_r)
        self._cap(rows)
        self._changed = True

    def _cap(self, rows: Ints) -> None:
        """Errors of nodes, and of what is known below them, are less than those of their parents by STEP."""
        table = self.table
        while len(rows):
            limit = table.capped_m[table.supports[rows, 0]] / STEP
            limit[table.supports[rows, 0] == UNKNOWN] = np.inf
            found = np.minimum(table.error_m[rows], limit)
            kids = table.kids[rows[found != table.capped_m[rows]]]
            table.capped_m[rows] = found
            rows = kids[kids > UNKNOWN]

    def forget(self, keys: ArrayLike) -> None:
        """Nodes can't be drawn any more; their parents will be, if need be."""
        keys = np.asarray(keys, dtype=np.int64).ravel()
        rows = self.table.find(keys)
        if self.table.split[self.table.supports[rows, 0]].any():
            self._leaves = None
        self.table.remove(keys)
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

    def touch(self, keys: ArrayLike) -> None:
        """Nodes, known or not, that will be of use: they don't become droppable before the next selection."""
        rows = self.table.find(np.asarray(keys, dtype=np.int64))
        self.table.used[rows[rows > UNKNOWN]] = self._call

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
        spacing_px: float | None = None,
        planes: Floats | None = None,
    ) -> Selection:
        """Tiles for an eye (3,), planet-centred metres; `pixel_rad` is the angle of a pixel.

        `time_s` runs the morphs; None finishes them at once. `velocity_m_s` (3,) is for what to make in advance,
        `planes` (P, 3), inward normals through the eye, for what to make first; they change nothing else.
        `spacing_px`: nor may vertices be farther apart than this. `max_tiles` is kept: the allowed error grows.
        Raises ValueError for an eye that isn't finite or is at the centre, and for limits that are not positive.
        """
        eye = np.asarray(eye_m, dtype=np.float64)
        if eye.shape != (3,) or not np.isfinite(eye).all() or not eye.any():
            raise ValueError(f"Forest.select: expected a finite eye_m (3,) away from the centre, found {eye_m!r}")
        limits = {"pixel_rad": pixel_rad, "error_px": error_px, "finest_spacing_m": finest_spacing_m}
        if spacing_px is not None:
            limits["spacing_px"] = spacing_px
        for name, value in limits.items():
            if not (np.isfinite(value) and value > 0):
                raise ValueError(f"Forest.select: {name} must be positive and finite, found {value!r}")
        if max_tiles < self.scheme.roots:
            raise ValueError(f"Forest.select: max_tiles must be at least {self.scheme.roots}, found {max_tiles!r}")
        asked = _Asked(pixel_rad, error_px, finest_spacing_m, spacing_px)
        moved = np.inf if self._eye is None else float(np.sqrt(((eye - self._eye) ** 2).sum()))
        same = not self._changed and (asked, max_tiles) == self._asked
        rests = self._last_eye is not None and bool((eye == self._last_eye).all())
        step_s, rested = self._clock(time_s, same and rests)
        self._last_eye = eye.copy()
        last = self._selection
        if (
            last is not None
            and same
            and not last.moving
            and moved <= self._slack_m
            and (not rests or not moved)
            and self._final >= rested
        ):
            return last
        if self._changed or self._weighed != asked:
            self._weigh(asked)
        self._asked, self._changed, self._eye = (asked, max_tiles), False, eye.copy()
        self.evaluations += 1
        self._call += 1
        velocity = None if velocity_m_s is None else np.asarray(velocity_m_s, dtype=np.float64)
        return self._run(eye, asked, max_tiles, step_s, rested, velocity, planes)

    def at_rest(self, eye_m: Floats) -> bool:
        """Whether `select` would give the last selection for that eye and the same limits, however often it is asked,
        and nothing in it moves."""
        done = self._final and not self._changed and self._selection is not None and not self._selection.moving
        return done and self._eye is not None and np.array_equal(eye_m, self._eye)

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

    def visible(self, selection: Selection, eye_m: ArrayLike, planes: Floats) -> Walked:
        """Which tiles of a selection a frustum may hold, by a walk down the trees; for priorities and for tests."""
        order = np.argsort(selection.keys)
        keys = selection.keys[order]
        rows = self.table.find(keys)
        walked = walk_frustum(self.scheme, keys, self.table.low[rows], self.table.high[rows], eye_m, planes)
        seen = np.zeros(len(keys), bool)
        seen[order] = walked.seen
        return walked._replace(seen=seen)

    def _weigh(self, asked: _Asked) -> None:
        """Share of a node times its distance, (R,) metres; and which nodes can be split at all."""
        table = self.table
        spacing = self._spacing_m[table.level]
        if self.split_distance_m is None:
            weight = table.capped_m / (asked.pixel_rad * asked.error_px)
            if asked.spacing_px is not None:
                weight = np.maximum(weight, spacing / (asked.pixel_rad * asked.spacing_px))
        else:
            reach = np.append(self.split_distance_m, 0.0)
            weight = reach[np.minimum(table.level, len(reach) - 1)]
        deepest = self.scheme.finest_level - (self.segments.bit_length() - 1)
        weight[(spacing <= asked.finest_spacing_m) | (table.level >= deepest) | ~table.known] = 0.0
        self._weighed, self._weights = asked, weight
        self._kids_known = np.all(table.kids > UNKNOWN, axis=1)
        self._parents = table.supports[:, 0].copy()
        self.hulls = Hulls(table.planes.reshape(-1, 3), table.reach, table.low, table.high, table.tangent)
        roots = self.scheme.root_keys()
        self._missing_roots = roots[table.find(roots) == UNKNOWN]

    def _run(
        self,
        eye: Floats,
        asked: _Asked,
        max_tiles: int,
        step_s: float,
        rested: bool,
        velocity: Floats | None,
        planes: Floats | None,
    ) -> Selection:
        table = self.table
        distance = self.hulls.distance(eye)
        np.maximum(distance, asked.finest_spacing_m, out=distance)
        counts = visible_share(distance, eye, self.hulls, self._occluder_r)
        alone = self._weights * counts / distance
        alone[GIVEN] = np.inf
        split = closed(table.split & self._kids_known, table.supports)
        share, needed, want = self._limited(alone, split, 1.0 if rested else 1.0 / HOLD, max_tiles)
        if rested or not np.isfinite(step_s):
            new, morph, moving = want, goals(share, want, table.supports), False
        else:
            new, morph, moving = step(share, want, split, table.morph, table.supports, step_s)
            if not self._fits(new, max_tiles):
                share, needed, want = self._limited(alone, split, 1.0, max_tiles)
                new, morph, moving = want, goals(share, want, table.supports), False
        morph[~new] = 1.0
        morph[GIVEN] = 0.0
        self._final = rested
        table.split, table.morph = new, morph
        inside = new[self._parents] & table.known
        table.used[inside] = self._call
        drawn = inside & ~new
        lacking = needed & drawn & ~self._kids_known
        self.lacking = int(lacking.sum())
        weights = self._weights
        if self._budget_step:
            weights = weights * 2.0 ** (-self._budget_step / BUDGET_STEPS)
        known = Known(self.hulls, weights, self._kids_known, self._missing_roots)
        wanted = self._foresight.wanted(known, share, lacking, drawn, eye, velocity, planes, self._call)
        return self._finish(distance, counts, drawn, wanted, moving, asked)

    def _fits(self, split: Mask, max_tiles: int) -> bool:
        # A split adds three leaves; row GIVEN is split as well.
        return self.scheme.roots + 3 * (int(split.sum()) - 1) <= max_tiles

    def _limited(self, share: Floats, split: Mask, hold: float, max_tiles: int) -> tuple[Floats, Mask, Mask]:
        """Shares, and what is to be split and can be, with an allowed error that keeps to max_tiles."""

        supports = self.table.supports

        def at(k: int) -> tuple[Floats, Mask, Mask, bool]:
            scaled = capped(share * 2.0 ** (-k / BUDGET_STEPS) if k else share, supports, hold)
            needed, want = wanted_split(scaled, split, self._kids_known, supports, hold)
            return scaled, needed, want, self._fits(want, max_tiles)

        # The smallest step that fits, by doubling and halving; seldom another than last time.
        k = self._budget_step
        found = at(k)
        if found[3]:
            low, high, reach = -1, k, 1
            while high > 0 and low < 0:
                finer = at(max(high - reach, 0))
                if finer[3]:
                    high, found, reach = max(high - reach, 0), finer, 2 * reach
                else:
                    low = max(high - reach, 0)
        else:
            low, high, reach = k, k + 1, 1
            while not (found := at(high))[3] and high < 64 * BUDGET_STEPS:
                low, reach = high, 2 * reach
                high += reach
        while high - low > 1 and low >= 0:
            middle = (low + high) // 2
            between = at(middle)
            if between[3]:
                high, found = middle, between
            else:
                low = middle
        self._budget_step = high
        return found[:3]

    def _find_leaves(self, rows: Ints, drawn: Mask) -> _Leaves:
        table = self.table
        keys = table.key[rows]
        order = np.argsort(keys)
        rows, keys = rows[order], keys[order]
        level, beside = table.level[rows], table.beside[rows]
        same = drawn[beside]
        if self.balanced:
            # A neighbour that is neither drawn nor split has a parent that is drawn; a missing root is nothing.
            skip = ~same & ~(table.split[beside] & (beside > UNKNOWN)) & (level > 0)[:, None]
        else:
            at = container_of(table.neighbour_keys[rows], keys)
            skip = np.where(at >= 0, level[:, None] - level[at], 0)
        place = np.zeros(len(drawn), np.int64)
        place[rows] = np.arange(len(rows))
        beside = np.where(same, place[beside], np.arange(len(rows))[:, None])
        return _Leaves(
            rows, table.supports[rows, 0], keys, level, skip.astype(np.uint8), beside, same.astype(np.float32)
        )

    def _finish(
        self, distance: Floats, counts: Floats, drawn: Mask, wanted: Ints, moving: bool, asked: _Asked
    ) -> Selection:
        fresh = self._leaves is None or not np.array_equal(drawn, self._drawn)
        if fresh:
            self._leaves, self._drawn = self._find_leaves(np.flatnonzero(drawn), drawn), drawn
        leaves = self._leaves
        assert leaves is not None
        own = np.rint(self.table.morph[leaves.parents] * MORPH_STEPS).astype(np.float32) * np.float32(1.0 / MORPH_STEPS)
        # The order of last time is nearly that of now.
        order = self._order if not fresh else np.arange(len(leaves.rows))
        away = distance[leaves.rows]
        order = self._order = order[np.argsort(away[order], kind="stable")]
        seen = order[counts[leaves.rows[order]] > 0.0]
        self._slack_m = SLACK * float(away[seen[0]]) if len(seen) else 0.0
        last = self._selection
        error_px = asked.error_px * 2.0 ** (self._budget_step / BUDGET_STEPS)
        if last is not None and not fresh and np.array_equal(seen, self._seen) and np.array_equal(own, self._morphs):
            values = (last.keys, last.morph, last.edge_skip, last.edge_morph)
            levels = last.levels
        else:
            edge = np.maximum(own[:, None], own[leaves.beside])
            edge *= leaves.same
            values = leaves.keys[seen], own[seen], leaves.skip[seen], edge[seen]
            levels = leaves.level[seen]
            self._revision += 1
        self._seen, self._morphs = seen, own
        self._selection = Selection(*values, away[seen], wanted, moving, self._revision, error_px, levels)
        return self._selection
