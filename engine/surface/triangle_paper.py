"""The icosphere as Lindner printed it (PlanetRenderer): split distances, back faces, volumes, morph ranges.

Everything is a table by level, made anew when the lens or the planet changes:

- split distance: the edge of a level over tan(pixels fov / width): a triangle is split when its flat middle is nearer.
  Edges halve from level to level. With patches the size that counts is that of one of their segments. Small pictures
  would then ask for triangles that are larger than far away; a camera beside one is far from its middle. So they are
  split from NEAREST edges at least (the source's own pictures never came near that).
- back faces: a triangle is dropped when the cosine between its middle's direction and the line of sight to it is at
  least sin(angle / 2^level + acos(r / (r + highest))), with angle = acos(0.5) and 0.5 for level 0.
- volume: a triangle's corners, and the corners times a height multiplier: how far the sphere bulges above the triangle
  plus highest / r. It is outside when all six lie behind one plane of the frustum, contained when all are in
  front of all planes; children of a contained one are not tested again.
- morph: by a vertex's distance, so that a level's vertices are all its own where finer triangles may lie beside them
  and all its parent's where coarser ones may. A triangle is split by the distance of its middle, and its vertices are
  at most `reach` from there. So its border to a finer one is at most split + reach away, and that to a coarser one at
  least the parent's split less the parent's reach: twice (split - reach). In between the morph runs. That needs
  split > 3 reach, which NEAREST sees to; levels on the two sides of an edge then differ by one at most.
- twist: a vertex moves along its edge to one of the two ends, so triangles twist as they morph. Beside each other they
  have to twist the opposite way round. Corners keep their places in a triangle's list when it is split as printed, and
  each new corner takes the place of the one opposite. So the lattice has three kinds of points, and whether level and
  orientation add up to an odd number says which way round a triangle's kinds run. Roots twist all alike, so along their
  edges vertices move apart.

The source's heights begin at 0: the sphere of the tables is that of the lowest ground, and highest what ground rises
above it. From a sphere that ground lies below, the printed culling drops triangles that can be seen.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .icosphere import EDGE_OVER_HEIGHT, TriangleScheme
from .scheme import Scheme

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

OUTSIDE, INTERSECTING, CONTAINED = 0, 1, 2
EDGE = float(1.0 / np.sin(2.0 * np.pi / 5.0))
"""Length of the icosahedron's edge on the unit sphere, 1.0515."""
REACH = float(EDGE_OVER_HEIGHT / np.sqrt(3.0))
"""How far a vertex of a root may lie from the root's middle at most, on the unit sphere; half of it a level down.
The limit for fine triangles in the middle of a root, 0.727 edges; all others reach less far."""
NEAREST = 2.5
"""In edges: triangles are split at this distance of their middles whatever pixels say. More than 3 reaches, 2.18."""


@dataclass(frozen=True, eq=False)
class PaperTables:
    """Tables by level 0 to most_level, (levels,) each."""

    split_m: Floats
    """A triangle of a level is split when its middle is nearer."""
    dot: Floats
    """... and dropped when the cosine of back faces is at least this."""
    height: Floats
    """What corners are multiplied with for the upper half of the volume."""
    morph_m: Floats
    """(levels, 2): distances at which vertices begin to morph, and at which they are their parent's."""


def tables(
    radius_m: float, highest_m: float, fov_rad: float, width_px: float, edge_px: float, segments: int, most_level: int
) -> PaperTables:
    """The tables for a lens of `fov_rad` across `width_px` pixels, segments of at most edge_px, patches of `segments`.

    Raises ValueError where an edge would be seen at 90 degrees or more: the tangent has no meaning then.
    """
    angle = edge_px * fov_rad / width_px
    if not 0.0 < angle < np.pi / 2:
        raise ValueError(f"tables: edge_px / width_px of the view has to be between 0 and 90 degrees, found {angle!r}")
    level = np.arange(most_level + 1)
    split = EDGE * radius_m * np.exp2(-level) * max(1.0 / (segments * np.tan(angle)), NEAREST)
    over = np.arccos(radius_m / (radius_m + max(highest_m, 0.0)))
    dot = np.sin(np.arccos(0.5) * np.exp2(-level) + over)
    dot[0] = 0.5 + np.sin(over)
    height = _height_multipliers(most_level) + max(highest_m, 0.0) / radius_m
    reach = REACH * (radius_m + max(highest_m, 0.0)) * np.exp2(-level)
    end = 2.0 * (split - reach)
    return PaperTables(split, dot, height, np.stack([np.minimum(split + reach, end), end], axis=1))


def _height_multipliers(most_level: int) -> Floats:
    """1 / cos of the angle between a corner and the first middle, while the middle triangle is split again and again.

    As printed: the middle is that of the root, and all the triangles in the middle share it.
    """
    a, b, c = TriangleScheme().corners(TriangleScheme().root_keys()[:1])[0]
    middle = (a + b + c) / np.linalg.norm(a + b + c)
    found = [1.0 / (a @ middle)]
    for _ in range(most_level):
        a, b, c = ((x + y) / np.linalg.norm(x + y) for x, y in ((b, c), (c, a), (a, b)))
        found.append(1.0 / (a @ middle))
    return np.array(found)


def back_faces(corners_m: Floats, level: ArrayLike, camera_m: ArrayLike, table: PaperTables) -> NDArray[np.bool_]:
    """Which triangles (N, 3, 3), corners on the sphere in metres, look away from the camera (3,)."""
    middle = corners_m.mean(axis=1)
    sight = middle - np.asarray(camera_m, dtype=np.float64)
    cosine = (middle * sight).sum(axis=1) / (np.linalg.norm(middle, axis=1) * np.linalg.norm(sight, axis=1))
    return cosine >= table.dot[np.asarray(level)]


def volume_state(
    corners_m: Floats, level: ArrayLike, camera_m: ArrayLike, planes: Floats, table: PaperTables
) -> NDArray[np.int64]:
    """OUTSIDE, INTERSECTING or CONTAINED (N,) for inward normals (P, 3) of planes through the camera."""
    upper = corners_m * table.height[np.asarray(level)][:, None, None]
    seen = np.concatenate([corners_m, upper], axis=1) - np.asarray(camera_m, dtype=np.float64)
    inside = np.einsum("nkc,pc->npk", seen, planes) >= 0.0
    out = (~inside).all(axis=2).any(axis=1)
    return np.where(out, OUTSIDE, np.where(inside.all(axis=(1, 2)), CONTAINED, INTERSECTING))


def hidden(
    corners_m: Floats, level: ArrayLike, camera_m: ArrayLike, planes: Floats, table: PaperTables
) -> NDArray[np.bool_]:
    """What the printed culling drops."""
    return back_faces(corners_m, level, camera_m, table) | (
        volume_state(corners_m, level, camera_m, planes, table) == OUTSIDE
    )


def frustum_planes(forward: ArrayLike, up: ArrayLike, tangents: tuple[float, float, float, float]) -> Floats:
    """Inward normals (4, 3) of the planes through a camera: left, right, bottom, top, from the tangents of these."""
    forward, up = np.asarray(forward, dtype=np.float64), np.asarray(up, dtype=np.float64)
    right = np.cross(forward, up)
    left, to_right, bottom, top = tangents
    return np.array([right - forward * left, forward * to_right - right, up - forward * bottom, forward * top - up])


@dataclass(frozen=True, eq=False)
class PaperSelection:
    """Leaves of the printed recursion."""

    keys: Ints
    """(N,)."""
    levels: Ints
    dropped: int
    """Triangles that culling ended, of all levels."""
    untested: int
    """Triangles whose volume was not tested, because one above them was contained."""


def select(
    scheme: Scheme,
    table: PaperTables,
    radius_m: float,
    camera_m: ArrayLike,
    planes: Floats,
    most_level: int,
    ground_m: float = 0.0,
    most: int = 1 << 14,
) -> PaperSelection:
    """The printed recursion, a level at a time: cull, split by distance, or draw. `planes` as in `volume_state`.

    ground_m: height of the sphere that distances are measured to; 0 as printed. Levels above which there would be more
    than `most` triangles are not begun."""
    camera = np.asarray(camera_m, dtype=np.float64)
    keys, contained = scheme.root_keys(), np.zeros(scheme.roots, bool)
    leaves: list[Ints] = []
    dropped = untested = 0
    for level in range(most_level + 1):
        corners = scheme.corners(keys) * radius_m
        levels = np.full(len(keys), level)
        keep = ~back_faces(corners, levels, camera, table)
        state = np.full(len(keys), CONTAINED)
        test = keep & ~contained
        state[test] = volume_state(corners[test], levels[test], camera, planes, table)
        untested += int((keep & contained).sum())
        keep &= state != OUTSIDE
        dropped += int((~keep).sum())
        keys, corners, contained = keys[keep], corners[keep], state[keep] == CONTAINED
        away = np.linalg.norm(corners.mean(axis=1) * (1.0 + ground_m / radius_m) - camera, axis=1)
        split = away < table.split_m[level]
        if level == most_level or sum(map(len, leaves)) + len(keys) + 3 * int(split.sum()) > most:
            split[:] = False
        leaves.append(keys[~split])
        keys, contained = scheme.children(keys[split]).ravel(), np.repeat(contained[split], 4)
        if not len(keys):
            break
    found = np.concatenate(leaves)
    return PaperSelection(found, scheme.level(found), dropped, untested)
