"""Culling of cells against dense samples of their ground: nothing visible is dropped, most of the rest is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...engine.space import CameraState, frustum_planes
from ...engine.surface.hulls import cells_hidden
from ...engine.surface.scheme import Scheme
from .selection import MadeGround

Floats = NDArray[np.float64]


@dataclass
class Culled:
    """Counts of pairs of a cell and a camera."""

    pairs: int = 0
    visible: int = 0
    """Pairs of which some sample is in the frustum and not behind the sphere below all ground."""
    dropped: int = 0
    """Of these, how many were culled: each is a hole."""
    culled: int = 0
    """Of the invisible ones, how many were culled."""

    @property
    def share(self) -> float:
        """Of the invisible ones."""
        return self.culled / max(self.pairs - self.visible, 1)


def cell_samples(corners: Floats, side: int) -> Floats:
    """Directions (S, 3) all over a cell with corners (E, 3), its edges and corners included."""
    t = np.linspace(0.0, 1.0, side)
    a, b = (g.ravel()[:, None] for g in np.meshgrid(t, t))
    if len(corners) == 4:
        points = (1 - b) * ((1 - a) * corners[0] + a * corners[1]) + b * ((1 - a) * corners[2] + a * corners[3])
    else:
        inside = (a + b <= 1.0 + 1e-12)[:, 0]
        a, b = a[inside], b[inside]
        points = (1 - a - b) * corners[0] + a * corners[1] + b * corners[2]
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def blocked(eye: Floats, points: Floats, radius: float) -> NDArray[np.bool_]:
    """Whether the straight line from an eye to each point passes through a sphere around the origin."""
    way = points - eye
    along = np.clip(-(way @ eye) / (way * way).sum(axis=1), 0.0, 1.0)
    nearest = np.linalg.norm(eye + along[:, None] * way, axis=1)
    # A point on the sphere, to within rounding, is not behind it.
    return nearest < radius * (1.0 - 1e-12)


def random_camera(ground: MadeGround, rng: np.random.Generator) -> CameraState:
    """A camera between half a metre and 15 radii above the ground, looking anywhere, mostly at the planet."""
    up = rng.normal(size=3)
    up /= np.linalg.norm(up)
    altitude = 10.0 ** rng.uniform(np.log10(0.5), np.log10(15.0 * ground.radius_m))
    eye = up * (ground.radius_m + float(ground.height(up[None])[0]) + altitude)
    forward = rng.normal(size=3)
    kind = rng.integers(4)
    if kind == 0:
        forward = -up + 0.2 * forward
    elif kind == 1:
        forward = forward - (forward @ up) * up + rng.uniform(-0.3, 0.1) * up
    return CameraState.look(
        eye, forward, rng.normal(size=3), float(rng.uniform(20.0, 100.0)), float(rng.uniform(0.5, 2.5))
    )


def random_pairs(ground: MadeGround, rng: np.random.Generator, count: int, side: int = 33) -> Culled:
    """Cells of all levels and cameras, `side`^2 samples of each cell, whose heights bound it."""
    scheme: Scheme = ground.scheme
    found = Culled()
    for _ in range(count):
        camera = random_camera(ground, rng)
        away = float(np.linalg.norm(camera.position_m))
        level = int(rng.integers(0, 20))
        # Some way off along the ground, in cells of the level: near, or as far as the horizon and beyond.
        offset = rng.normal(size=3) * min(10.0 ** rng.uniform(-0.5, 2.0) * scheme.spacing_rad(level, 1), 1.5)
        towards = camera.position_m / away + offset
        key = scheme.at((towards / np.linalg.norm(towards))[None], level)
        directions = cell_samples(scheme.corners(key)[0], side)
        heights = ground.height(directions)
        points = directions * (ground.radius_m + heights)[:, None]
        planes = np.concatenate([frustum_planes(camera), camera.forward[None]])
        inside = ((points - camera.position_m) @ planes.T >= 0.0).all(axis=1)
        seen = bool((inside & ~blocked(camera.position_m, points, ground.radius_m - ground.relief_m)).any())
        hidden = bool(
            cells_hidden(
                scheme, key, heights.min(), heights.max(), ground.radius_m, camera.position_m, planes, -ground.relief_m
            )[0]
        )
        found.pairs += 1
        found.visible += seen
        found.dropped += seen and hidden
        found.culled += hidden and not seen
    return found
