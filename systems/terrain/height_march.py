"""Spheres against the ground, float64: nearest points by tangent planes, sweeps by clearances."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .height import TerrainField

__all__ = ["contact", "surface_normal", "sweep"]

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

_SMALLEST_STEP_M = 1e-3
_STARTS = np.array([[0.0, 0.7, -0.7, 0.0, 0.0], [0.0, 0.0, 0.0, 0.7, -0.7]])
"""In radii: nearest points are sought from below the centre and from around it."""
_LARGE_M = 10.0
"""A larger sphere spans several bumps of the ground's finest layers: more places to start from."""
_LARGE_STARTS = 0.45 * np.stack(np.meshgrid(np.arange(-2, 3), np.arange(-2, 3))).reshape(2, -1)
_NEAREST_STEPS = 12
_NEAREST_SHARE = 3e-3
"""Of the radius: a last step that is smaller leaves the distance wrong by less than 1e-5 of the radius."""


def surface_normal(field: TerrainField, directions: Floats, footprint_m: float | None = None) -> tuple[Floats, Floats]:
    """Heights (N,) and unit normals (N, 3) of the ground at unit directions (N, 3)."""
    heights, gradient = field.height_gradient(directions, footprint_m)
    normal = directions - gradient * (field.radius_m / (field.radius_m + heights))[:, None]
    return heights, normal / np.linalg.norm(normal, axis=1)[:, None]


def _nearest(field: TerrainField, centers: Floats, reach_m: Floats, below_m: Floats) -> tuple[Floats, Floats]:
    """Distances (N,) to the ground, and the directions to it (N, 3) as unit normals pointing up. below_m: heights (N,)
    of the ground right below the centres.

    From the best of five places (25 for a large sphere) below the centre and around it, the nearest point is sought by
    projecting the centre onto tangent planes, which are found by differences of heights: three heights a step are
    cheaper than one gradient.
    """
    large = reach_m > _LARGE_M
    if large.any() and not large.all():
        best, normals = np.empty(len(centers)), np.empty((len(centers), 3))
        for part in (large, ~large):
            best[part], normals[part] = _nearest(field, centers[part], reach_m[part], below_m[part])
        return best, normals
    starts = _LARGE_STARTS if large.all() else _STARTS
    count, radius = len(centers), field.radius_m
    foot = centers / np.linalg.norm(centers, axis=1)[:, None]
    side = np.cross(foot, np.eye(3)[np.abs(foot).argmin(axis=1)])
    side /= np.linalg.norm(side, axis=1)[:, None]
    other = np.cross(foot, side)
    # Places are metres (x, y) on the plane that touches the reference sphere below the centre.
    x, y = (np.outer(line, reach_m) for line in starts)

    def surface(x: Floats, y: Floats, at: NDArray[np.intp]) -> Floats:
        """Points (..., 3) of the ground, from the centre of the sphere, below places (..., n) of the spheres `at`."""
        d = foot[at] + (x[..., None] * side[at] + y[..., None] * other[at]) / radius
        d /= np.linalg.norm(d, axis=-1)[..., None]
        heights = field.height(d.reshape(-1, 3)).reshape(x.shape)
        return d * (radius + heights)[..., None] - centers[at]

    everyone = np.arange(count)
    if large.all():
        first = surface(x, y, everyone)
    else:
        right_below = foot * (radius + below_m)[:, None] - centers
        first = np.concatenate([right_below[None], surface(x[1:], y[1:], everyone)])
    start = np.linalg.norm(first, axis=-1).argmin(axis=0)
    place = np.stack([x[start, everyone], y[start, everyone]])
    if not large.all():
        # Where the ground is a gentle parabola, its nearest point is nearer to the truth than any of the five.
        away = -(first * foot).sum(axis=-1)  # how far below the centre
        arm = _STARTS[0, 1] * reach_m
        slope = np.stack([away[2] - away[1], away[4] - away[3]]) / (2.0 * arm)
        bend = (2.0 * away[0] - np.stack([away[1] + away[2], away[3] + away[4]])) / (arm * arm)
        stiff = 1.0 + slope * slope - away[0] * bend
        parabola = -away[0] * slope / np.maximum(stiff, 0.3)
        gentle = (stiff > 0.5).all(axis=0) & ((parabola * parabola).sum(axis=0) < reach_m * reach_m)
        place = np.where(gentle, parabola, place)
    best, normals = np.full(count, np.inf), foot.copy()
    active, step = everyone, np.clip(1e-4 * reach_m, 1e-4, 1.0)
    for _ in range(_NEAREST_STEPS):
        h = step[active]
        x, y = place[:, active]
        p, px, py = surface(np.stack([x, x + h, x]), np.stack([y, y, y + h]), active)
        normal = np.cross(px - p, py - p)
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        # The centre's foot on the tangent plane, seen from the point, is where to look next. Once that is near, the
        # plane's distance is the ground's, but for the square of the step times the ground's curvature.
        along = (p * normal).sum(axis=1)
        move = normal * along[:, None] - p
        near = (move * move).sum(axis=1) < (_NEAREST_SHARE * reach_m[active]) ** 2
        distance = np.where(near, np.abs(along), np.linalg.norm(p, axis=1))
        better = distance < best[active]
        found = active[better]
        best[found], normals[found] = distance[better], normal[better]
        move = np.stack([(move * side[active]).sum(axis=1), (move * other[active]).sum(axis=1)])
        place[:, active] += move
        active = active[~near]
        if not active.size:
            break
    return best, normals


def contact(field: TerrainField, centers: Floats, radii: Floats) -> tuple[Floats, Floats]:
    """Depth (N,) of spheres in the ground, negative when they are clear of it, and normals (N, 3) to push them out.

    The nearest point is found by projecting the centre onto tangent planes, from several starts. A sphere so far up
    that no slope can reach it keeps its height above the ground as its clearance.
    """
    distance = np.maximum(np.linalg.norm(centers, axis=1), 1e-9)
    below = field.height(centers / distance[:, None])
    clearance = distance - field.radius_m - below
    depth, normal = radii - clearance, centers / distance[:, None]
    close = np.flatnonzero(clearance < radii * np.hypot(1.0, field.steepest))
    if close.size:
        # Under the ground the way out is up: the nearest surface may be a far side of a hill.
        reach = np.maximum(radii[close], np.abs(clearance[close]))
        gap, out = _nearest(field, centers[close], reach, below[close])
        depth[close] = radii[close] - np.where(clearance[close] < 0.0, -gap, gap)
        normal[close] = out
    return depth, normal


def sweep(field: TerrainField, start: Floats, end: Floats, radii: Floats) -> tuple[Flags, Floats, Floats]:
    """First contact of spheres going straight from `start` to `end`: hit (N,), fraction (N,) of the way, normal (N, 3).

    Conservative advancement: each step is the sphere's clearance from the nearest ground, and at least 1 mm and 5 %
    more each time. Fraction 1 where nothing is hit, 0 where the start touches.
    """
    count, way = len(start), end - start
    length = np.linalg.norm(way, axis=1)
    moved, hit, normal = np.zeros(count), np.zeros(count, dtype=bool), np.zeros((count, 3))
    active, smallest = np.arange(count), _SMALLEST_STEP_M
    flat = np.hypot(1.0, field.steepest)
    while active.size:
        share = moved[active] / np.maximum(length[active], 1e-300)
        centers = start[active] + np.minimum(share, 1.0)[:, None] * way[active]
        depth, out = contact(field, centers, radii[active])
        touching = depth >= -_SMALLEST_STEP_M
        hit[active[touching]] = True
        normal[active[touching]] = out[touching]
        going = ~touching & (moved[active] < length[active])
        # Beyond contact's close range the clearance is straight down; ground that rises may be nearer by the slope.
        clear = np.where(
            -depth + radii[active] < radii[active] * flat, -depth, (radii[active] - depth) / flat - radii[active]
        )
        active, clear = active[going], clear[going]
        moved[active] = np.minimum(moved[active] + np.maximum(clear, smallest), length[active])
        smallest *= 1.05
    return hit, np.where(hit, moved / np.maximum(length, 1e-300), 1.0), normal
