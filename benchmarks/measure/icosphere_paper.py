"""What the icosphere's printed method loses: visible triangles that its culling drops, gaps between its levels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...engine.surface.icosphere import TriangleScheme
from ...engine.surface.triangle_paper import hidden, tables

Floats = NDArray[np.float64]
SCHEME = TriangleScheme()
# The ground of tests/data/terrain_cull_triangles.csv: a sum of waves, heights within plus and minus the amplitude.
_WAVES = np.array(
    [[3.1, -1.7, 2.3], [-7.9, 5.2, 4.4], [17, 23, -19], [-61, 37, 53], [151, -167, 173], [-911, 953, 887],
     [5003, 4999, -5009]]
)  # fmt: skip
_PHASES = np.array([0.1, 1.2, 2.3, 3.4, 4.5, 5.6, 0.7])
_SHARES = np.array([0.45, 0.25, 0.15, 0.08, 0.04, 0.02, 0.01])
SAMPLES = 48  # points along a side


@dataclass(frozen=True)
class Dropped:
    """Triangles seen by dense sampling and those of them that are dropped; and the same of the unseen ones."""

    visible: int
    visible_dropped: int
    invisible: int
    invisible_dropped: int


def height_m(directions: Floats, amplitude_m: float) -> Floats:
    """Heights (...,) of the waves at unit directions (..., 3)."""
    return amplitude_m * (np.sin(directions @ _WAVES.T + _PHASES) @ _SHARES)


def printed_culling(
    rng: np.random.Generator,
    cases: int,
    radius_m: float = 6.371e6,
    amplitude_m: float = 9000.0,
    sphere_m: float | None = None,
) -> Dropped:
    """Random cameras over random ground, and random triangles around them: what the printed culling makes of them.

    A triangle is visible if a sample of its ground is in the frustum and the sphere of the lowest ground is not in
    between. sphere_m: height of the sphere that triangles are on. That of the lowest ground by default: the source's
    heights begin at 0."""
    sphere_m = -amplitude_m if sphere_m is None else sphere_m
    base_m, relief_m = radius_m + sphere_m, amplitude_m - sphere_m
    q, p = np.nonzero(np.add.outer(np.arange(SAMPLES + 1), np.arange(SAMPLES + 1)) <= SAMPLES)
    weights = np.stack([SAMPLES - p - q, p, q], axis=-1) / SAMPLES
    counts = np.zeros((2, 2), int)
    for _ in range(cases):
        camera, planes, tangents = _camera(rng, radius_m, amplitude_m)
        level = int(rng.integers(1, 13))
        away = rng.normal(size=3) * 10.0 ** rng.uniform(-3.0, 0.0)
        key = SCHEME.at(camera / np.linalg.norm(camera) + away, level)
        corners = SCHEME.corners(key[None])
        directions = weights @ corners[0]
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        points = directions * (radius_m + height_m(directions, amplitude_m))[:, None]
        inside = (((points - camera) @ planes.T) >= 0.0).all(axis=1)
        seen = bool((inside & ~_occluded(camera, points, radius_m - amplitude_m)).any())
        table = tables(base_m, relief_m, 2.0 * np.arctan(tangents[0]), 1920, 6.0, 16, level)
        drops = bool(hidden(corners * base_m, [level], camera, planes, table)[0])
        counts[int(seen), int(drops)] += 1
    return Dropped(int(counts[1].sum()), int(counts[1, 1]), int(counts[0].sum()), int(counts[0, 1]))


def _camera(
    rng: np.random.Generator, radius_m: float, amplitude_m: float
) -> tuple[Floats, Floats, tuple[float, float]]:
    """Above the ground by 2 m to 3 radii, looking anywhere, 40 to 90 degrees across."""
    zenith = rng.normal(size=3)
    zenith /= np.linalg.norm(zenith)
    above = 10.0 ** rng.uniform(np.log10(2.0), np.log10(3.0 * radius_m))
    camera = zenith * (radius_m + height_m(zenith, amplitude_m) + above)
    forward = rng.normal(size=3) - rng.uniform(0.0, 2.0) * zenith
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, rng.normal(size=3))
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    wide = np.tan(np.radians(rng.uniform(40.0, 90.0)) / 2)
    high = wide * 9 / 16
    planes = np.array([right + forward * wide, forward * wide - right, up + forward * high, forward * high - up])
    return camera, planes, (float(wide), float(high))


def _occluded(camera: Floats, points: Floats, radius_m: float) -> NDArray[np.bool_]:
    """Whether the sphere lies between the camera and points (N, 3)."""
    sight = points - camera
    square = (sight * sight).sum(axis=1)
    t = np.clip(-(sight @ camera) / square, 0.0, 1.0)
    nearest = camera + sight * t[:, None]
    return (nearest * nearest).sum(axis=1) < radius_m**2


def gap_between_levels_m(radius_m: float, level: int) -> tuple[float, float]:
    """How far apart vertices are that two levels should share, as printed: each level interpolates its own corners,
    which were pushed out to the sphere when it was split. Metres, along an edge of the icosahedron and at worst.

    A side of a triangle of `level` against the two sides of its children along it, at their middles.
    """
    a, b, c = SCHEME.corners(SCHEME.root_keys()[:1])[0]
    corner, middle = (a, b, c), (a, b, c)
    for _ in range(level):
        corner = (corner[0], _unit(corner[0] + corner[1]), _unit(corner[0] + corner[2]))
        middle = tuple(_unit(middle[k - 2] + middle[k - 1]) for k in range(3))
    return _gap(corner[0], corner[1]) * radius_m, max(_gap(middle[k - 1], middle[k]) for k in range(3)) * radius_m


def _gap(x: Floats, y: Floats) -> float:
    return float(np.linalg.norm(_unit(0.75 * x + 0.25 * y) - _unit(x + _unit(x + y))))


def _unit(v: Floats) -> Floats:
    return v / np.linalg.norm(v)
