"""Hulls of cells: what a cell's ground certainly lies in, between two heights above a spherical polygon.

Distances to them, whether the planet hides them, and whether a frustum holds them. All bounds err to the side of nearer
and of drawn.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .keys import MAX_LEVEL, children_of, first_inside, last_inside, level_of
from .scheme import Scheme

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]

OUTSIDE, INTERSECTING, CONTAINED = 0, 1, 2
"""States of a hull and a frustum."""

WHOLE_LEVEL = 3
"""Cells coarser than this are tested as their descendants of this level: a hull of a large part of a sphere is big."""
ROUNDING = 1e-12
"""Relative to the distances involved: far above the errors of float64, far below a pixel."""
FADE = 0.15
"""Errors fade to nothing over this part of the distance to the horizon, beyond it."""
SQUARE_ROUNDING = 2e-15
"""Squares of distances are good to this times the squared distance from the planet's centre: squared chords come from
2 - 2 cos, and the cosine of three rounded products is good to 4e-16."""


class Hulls(NamedTuple):
    """Bounds of N cells, prepared for many distances."""

    planes: Floats
    """((1 + E) N, 3): the cells' centres, then the inward normals of their first edges, of their second, ..."""
    reach: Floats
    """(N,): chord from the centre to the farthest corner, on the unit sphere."""
    low: Floats
    """(N,), from the planet's centre."""
    high: Floats
    tangent: Floats
    """(N,): the longest tangent to the sphere that hides from the cell's highest ground; its length in metres."""

    @classmethod
    def of(cls, center: Floats, reach: Floats, normals: Floats, low: Floats, high: Floats, occluder: float) -> "Hulls":
        """From centres (N, 3), normals (N, E, 3) and radii (N,); `occluder` is the radius of the sphere that hides."""
        planes = np.concatenate([center[None], normals.transpose(1, 0, 2)]).reshape(-1, 3)
        return cls(planes, reach, low, high, tangent_length(high, occluder))

    def distance(self, eye_m: Floats) -> Floats:
        """Lower bounds of the distances from a point (3,) to the cells, (N,) metres; see SQUARE_ROUNDING."""
        away = float(np.sqrt(eye_m @ eye_m))
        dots = (self.planes @ (eye_m / away)).reshape(-1, len(self.reach))
        # The chord to the nearest point: no less than that to the centre without the reach; and, where the point is
        # beyond an edge, no less than that to the edge's great circle, whose sine is the distance from its plane.
        chord = np.sqrt(np.maximum(2.0 - 2.0 * dots[0], 0.0))
        chord -= self.reach
        np.maximum(chord, 0.0, out=chord)
        chord *= chord
        beyond = np.minimum(dots[1:].min(axis=0), 0.0)
        beyond *= beyond
        cosine = np.sqrt(np.maximum(1.0 - beyond, 0.0))
        cosine += 1.0
        beyond *= 2.0
        beyond /= cosine
        np.maximum(chord, beyond, out=chord)
        # Nearest height on that direction: away cos(angle), if the cell has it.
        height = np.maximum(np.minimum(away * (1.0 - 0.5 * chord), self.high), self.low)
        chord *= away
        chord *= height
        height -= away
        height *= height
        chord += height
        return np.sqrt(chord, out=chord)


def tangent_length(radius: Floats, occluder: float) -> Floats:
    """Lengths (N,) of the tangents to the sphere that hides from points at these radii; 0 inside it."""
    above = np.maximum(radius - occluder, 0.0)
    return np.sqrt(above * (2.0 * occluder + above))


def horizon_reach(eye_m: Floats, occluder: float) -> float:
    """Length of the tangent from an eye to the sphere that hides; infinite inside it.

    Of two points above a sphere one hides from the other when they are farther apart than their tangents together.
    """
    above = float(np.sqrt(eye_m @ eye_m)) - occluder
    return float(np.sqrt(above * (2.0 * occluder + above))) if above > 0.0 else np.inf


def visible_share(distance: Floats, eye_m: Floats, hulls: Hulls, occluder: float) -> Floats:
    """How much of the cells' errors counts, (N,): 1, less beyond the horizon, 0 for what is hidden for certain."""
    reach = horizon_reach(eye_m, occluder)
    if not np.isfinite(reach):
        return np.ones(len(distance))
    # Not less than a little: an eye on the sphere that hides sees its own foot.
    limit = hulls.tangent + max(reach, 1e-6 * occluder)
    np.divide(distance, limit, out=limit)
    limit -= 1.0 + FADE
    limit *= -1.0 / FADE
    return np.minimum(np.maximum(limit, 0.0, out=limit), 1.0, out=limit)


def hull_points(corners: Floats, low: ArrayLike, high: ArrayLike, eye_m: ArrayLike = (0.0, 0.0, 0.0)) -> Floats:
    """Corners (N, 2 E, 3), relative to eye_m, of convex hulls around cells between the radii low and high, (N,).

    Each direction of the polygon is a convex combination of the corners (N, E, 3) over its length, which is at least
    the cosine of the angle between middle and corners: the highest ground lies below the corners over that cosine.
    """
    middle = corners.mean(axis=1)
    middle /= np.sqrt((middle * middle).sum(axis=1))[:, None]
    cosine = (corners * middle[:, None, :]).sum(axis=2).min(axis=1) * (1.0 - 1e-15)
    shape = (len(corners), 1, 1)
    inner = corners * np.broadcast_to(low, len(corners)).reshape(shape)
    outer = corners * (np.broadcast_to(high, len(corners)) / cosine).reshape(shape)
    return np.concatenate([inner, outer], axis=1) - np.asarray(eye_m, dtype=np.float64)


def frustum_states(points: Floats, planes: Floats) -> NDArray[np.uint8]:
    """OUTSIDE, INTERSECTING or CONTAINED, (N,): hulls (N, K, 3) relative to the eye, planes through it (P, 3)."""
    side = points.reshape(-1, 3) @ planes.T
    side = side.reshape(len(points), points.shape[1], len(planes))
    scale = np.abs(points).max(axis=(1, 2))[:, None]
    outside = (side.max(axis=1) < -ROUNDING * scale).any(axis=1)
    inside = (side.min(axis=1) >= ROUNDING * scale).all(axis=1)
    return np.where(outside, OUTSIDE, np.where(inside, CONTAINED, INTERSECTING)).astype(np.uint8)


def cells_hidden(
    scheme: Scheme,
    keys: Ints,
    low_m: ArrayLike,
    high_m: ArrayLike,
    radius_m: float,
    eye_m: ArrayLike,
    planes: Floats,
    occluder_m: float,
) -> Mask:
    """Which cells (N,) with ground between two heights are certainly out of view, or behind the sphere radius_m +
    occluder_m: none of their parts is in a frustum and above the horizon.

    `planes`: inward normals (P, 3) of planes through the eye (the camera's forward vector may be one of them).
    """
    keys = np.asarray(keys, dtype=np.int64)
    low = np.broadcast_to(np.asarray(low_m, dtype=np.float64), keys.shape) + radius_m
    high = np.broadcast_to(np.asarray(high_m, dtype=np.float64), keys.shape) + radius_m
    parts, owner = _parts(keys)
    return ~_seen_parts(scheme.corners(parts), owner, len(keys), low, high, radius_m + occluder_m, eye_m, planes)


def polygons_hidden(
    corners: Floats, low: ArrayLike, high: ArrayLike, occluder: float, eye_m: ArrayLike, planes: Floats
) -> Mask:
    """The same for polygons with corners (N, K, 3) between radii; they are not taken apart."""
    owner = np.arange(len(corners))
    low, high = (np.broadcast_to(np.asarray(a, dtype=np.float64), len(corners)) for a in (low, high))
    return ~_seen_parts(corners, owner, len(corners), low, high, occluder, eye_m, planes)


def _parts(keys: Ints) -> tuple[Ints, Ints]:
    """Descendants of WHOLE_LEVEL in place of coarser cells, and whose each is."""
    owner = np.arange(len(keys))
    while (coarse := level_of(keys) < WHOLE_LEVEL).any():
        keys = np.concatenate([keys[~coarse], children_of(keys[coarse]).ravel()])
        owner = np.concatenate([owner[~coarse], np.repeat(owner[coarse], 4)])
    return keys, owner


def _seen_parts(
    corners: Floats,
    owner: Ints,
    count: int,
    low: Floats,
    high: Floats,
    occluder: float,
    eye_m: ArrayLike,
    planes: Floats,
) -> Mask:
    eye = np.asarray(eye_m, dtype=np.float64)
    points = hull_points(corners, low[owner], high[owner], eye)
    seen = frustum_states(points, planes) != OUTSIDE
    center = corners.mean(axis=1)
    center /= np.sqrt((center * center).sum(axis=1))[:, None]
    reach = np.sqrt(((corners - center[:, None]) ** 2).sum(axis=2).max(axis=1))
    hulls = Hulls.of(center, reach, _ring_normals(corners, center), low[owner], high[owner], occluder)
    limit = horizon_reach(eye, occluder) + hulls.tangent
    away = float(np.sqrt(eye @ eye))
    seen &= hulls.distance(eye) ** 2 <= limit**2 * (1.0 + ROUNDING) + SQUARE_ROUNDING * away * hulls.high
    result = np.zeros(count, bool)
    result[owner[seen]] = True
    return result


def _ring_normals(corners: Floats, center: Floats) -> Floats:
    """Inward normals of a polygon's edges whatever the order of its corners: K planes, each with all corners inside.

    Corners are sorted by their angle around the centre.
    """
    first = corners[:, 0] - center
    side = np.cross(center, first)
    offset = corners - center[:, None]
    turn = np.arctan2((offset * side[:, None]).sum(axis=2), (offset * first[:, None]).sum(axis=2))
    ring = np.take_along_axis(corners, np.argsort(turn, axis=1)[..., None], axis=1)
    normals = np.cross(ring, np.roll(ring, -1, axis=1) - ring)
    normals /= np.sqrt((normals * normals).sum(axis=2))[..., None]
    return normals


class Walked(NamedTuple):
    """What a walk down the trees found."""

    seen: Mask
    """(N,), of the leaves."""
    tested: int
    """How many hulls were tested."""
    contained: int
    """How many leaves were accepted with a node above them, untested."""


def walk_frustum(
    scheme: Scheme, leaves: Ints, low: Floats, high: Floats, eye_m: ArrayLike, planes: Floats, from_level: int = 2
) -> Walked:
    """Which leaves (sorted keys, none inside another) between radii low and high, (N,), a frustum may hold.

    Nodes are tested from `from_level` down, with the bounds of the leaves inside them. One that is outside, or
    contained, settles all its leaves.
    """
    eye = np.asarray(eye_m, dtype=np.float64)
    seen = np.zeros(len(leaves), bool)
    tested = contained = 0
    level = level_of(leaves)
    bit = np.int64(1) << 2 * (MAX_LEVEL - np.minimum(level, from_level))
    nodes = np.unique((leaves & -bit) | bit)
    while len(nodes):
        start = np.searchsorted(leaves, first_inside(nodes))
        stop = np.searchsorted(leaves, last_inside(nodes), side="right")
        there = stop > start
        nodes, start, stop = nodes[there], start[there], stop[there]
        if not len(nodes):
            break
        # Minima and maxima over intervals [start, stop): every other interval of reduceat is what lies between.
        ends = np.stack([start, np.minimum(stop, len(leaves) - 1)], axis=1).ravel()
        floor, top = np.minimum.reduceat(low, ends)[::2], np.maximum.reduceat(high, ends)[::2]
        last = stop == len(leaves)
        floor[last], top[last] = np.minimum(floor[last], low[-1]), np.maximum(top[last], high[-1])
        states = frustum_states(hull_points(scheme.corners(nodes), floor, top, eye), planes)
        tested += len(nodes)
        whole = states == CONTAINED
        one = (stop - start == 1) & (leaves[start] == nodes)
        for a, b in zip(start[whole].tolist(), stop[whole].tolist(), strict=True):
            seen[a:b] = True
        contained += int((stop - start)[whole & ~one].sum())
        between = states == INTERSECTING
        seen[start[between & one]] = True
        nodes = children_of(nodes[between & ~one]).ravel()
    return Walked(seen, tested, contained)
