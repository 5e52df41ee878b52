"""The drawn sea against the true one: which pixels are sea, ground or nothing, and where the sea's surface lies.

The truth is float64 and shares nothing with the shaders: along a pixel's ray the first ground of TerrainSampler.raycast
or the sphere of the sea's level, whichever is nearer.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ... import Camera, Ocean, Renderer, TerrainSampler
from ...engine.space import CameraState, ray_sphere_from
from .drawn import some
from .ground import on_screen_px

NOTHING, TERRAIN, SEA = 0, 1, 2
EDGE_PX = 1.0
"""A pixel whose true boundary lies nearer than this is not wrong: a class is one sample of a whole pixel."""
LOST_PX = 2.0

Floats = NDArray[np.float64]
Surfaces = NDArray[np.uint8]

_RINGS_PX = (0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0)
_SPOKES = 16


class Truth:
    """A scene's ground and sea, looked at from one camera."""

    def __init__(self, renderer: Renderer, camera: CameraState) -> None:
        planet = renderer.scene.planet
        self.sampler = TerrainSampler(renderer.scene)
        self.camera, self.size = camera, renderer.size
        self.sea_radius_m = self.sampler.radius_m + planet[Ocean].sea_level_m

    def rays(self, pixels: Floats) -> Floats:
        """Unit directions (N, 3) through places (N, 2) of the picture: x right, y down, middles at halves."""
        c, (width, height) = self.camera, self.size
        x = c.tan_left + (c.tan_right - c.tan_left) * pixels[:, 0] / width
        y = c.tan_top - (c.tan_top - c.tan_bottom) * pixels[:, 1] / height
        rays = x[:, None] * c.right + y[:, None] * c.up + c.forward
        return rays / np.linalg.norm(rays, axis=1)[:, None]

    def look(self, pixels: Floats) -> tuple[Surfaces, Floats]:
        """What is seen (N,) and its distance in metres (N,), inf for nothing, at places (N, 2) of the picture."""
        rays = self.rays(pixels)
        sea = ray_sphere_from(self.camera.position_m, rays, self.sea_radius_m)
        ground, distance = self.sampler.raycast(self.camera.position_m, rays, sea.near_m)
        # Where both are met at one place, the line of the coast itself, either will do.
        found = np.where(ground, TERRAIN, np.where(sea.hit, SEA, NOTHING)).astype(np.uint8)
        return found, np.where(ground, distance, sea.near_m)


@dataclass(frozen=True)
class Classes:
    """How right a set of pixels is about what it shows. Shares are NaN where there are no pixels."""

    pixels: int
    wrong: float
    """Share of pixels whose class is not the truth's at their middle."""
    wrong_beyond: float
    """Of those whose true boundary is not even within EDGE_PX."""


@dataclass(frozen=True)
class SeaError:
    """One view's sea against the truth."""

    sea_pixels: int
    """Drawn as sea and truly sea, among those looked at."""
    p99_px: float
    worst_px: float
    """How far such a pixel's point moves on screen when it is moved up or down to the sphere of the sea's level."""
    p99_distance: float
    """Its distance from the camera against the true ray's, relative."""
    sampled: Classes
    """Random pixels of the picture."""
    edge: Classes
    """Pixels that have a neighbour of another class: coasts and the limb."""
    worst_off_px: float
    """How far the true boundary is from the pixel that is most wrong; 0 where all are right, inf beyond 32 pixels."""
    lost: int
    """Pixels that show what truly is nowhere within LOST_PX: sea where ground hides all of it."""


def sea_error(
    renderer: Renderer, camera: Camera, rng: np.random.Generator, most: int = 3000, most_edge: int | None = None
) -> SeaError:
    """Look at `most` random pixels and at `most_edge` (None: all) of those along edges between classes.

    RuntimeError for a planet without Terrain or without Ocean.
    """
    planet = renderer.scene.planet
    if not planet.has(Ocean) or planet.height_field() is None:
        raise RuntimeError("the planet has no Terrain or no Ocean: no coast to measure")
    out = renderer.render(camera, outputs=("position", "surface"))
    drawn, width = out["surface"], renderer.size[0]
    truth = Truth(renderer, renderer.camera_state(camera))
    sampled = some(np.ones(drawn.shape, bool), rng, most).ravel()
    edge = edges(drawn)
    edge = (edge if most_edge is None else some(edge, rng, most_edge)).ravel()
    places = np.flatnonzero(sampled | edge)
    rows, columns = np.divmod(places, width)
    pixels = np.stack([columns + 0.5, rows + 0.5], axis=1)
    true, distance = truth.look(pixels)
    shown = drawn[rows, columns]

    right_sea = (shown == SEA) & (true == SEA)
    seen = out["position"][rows, columns][right_sea].astype(np.float64)
    moved_px = surface_error_px(truth, seen)
    relative = np.abs(np.linalg.norm(seen, axis=1) / distance[right_sea] - 1.0)

    wrong = shown != true
    boundary, same = np.zeros(len(places)), np.zeros(len(places))
    boundary[wrong], same[wrong] = off_by_px(truth, pixels[wrong], shown[wrong], true[wrong])

    def classes(chosen: NDArray[np.bool_]) -> Classes:
        here = chosen[places]
        return Classes(int(here.sum()), _share(wrong[here]), _share(boundary[here] > EDGE_PX))

    return SeaError(
        int(right_sea.sum()), *_tail(moved_px), _tail(relative)[0], classes(sampled), classes(edge),
        float(boundary.max()), int((same > LOST_PX).sum()),
    )  # fmt: skip


def edges(classes: Surfaces) -> NDArray[np.bool_]:
    """Which pixels (H, W) have one of their four neighbours in another class."""
    found = np.zeros(classes.shape, bool)
    across, down = classes[:, 1:] != classes[:, :-1], classes[1:] != classes[:-1]
    found[:, 1:] |= across
    found[:, :-1] |= across
    found[1:] |= down
    found[:-1] |= down
    return found


def surface_error_px(truth: Truth, seen: Floats) -> Floats:
    """How far points (N, 3) relative to the camera move on screen, in pixels, when moved up or down to the sea."""
    point = truth.camera.position_m + seen
    distance = np.linalg.norm(point, axis=1)
    moved = seen + point / distance[:, None] * (truth.sea_radius_m - distance)[:, None]
    return on_screen_px(truth.camera, seen, moved, truth.size)


def off_by_px(truth: Truth, pixels: Floats, shown: Surfaces, true: Surfaces) -> tuple[Floats, Floats]:
    """Distances in pixels from places (N, 2) that show the class `shown` (N,) where the truth is `true` (N,).

    (to the nearest place whose truth is another class: how near the true boundary is; to the nearest place that truly
    is what is shown, which where a ridge hides the sea may be none.) Rings of 16 places each are tried from the inside
    out, inf beyond the last: never too small, and too large by a ring where the class there is more than a sliver.
    """
    boundary, same = np.full(len(pixels), np.inf), np.full(len(pixels), np.inf)
    angle = 2.0 * np.pi * np.arange(_SPOKES) / _SPOKES
    spokes = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    for radius in _RINGS_PX:
        left = np.flatnonzero(np.isinf(same))
        if not left.size:
            break
        around = (pixels[left, None] + radius * spokes).reshape(-1, 2)
        found = truth.look(around)[0].reshape(-1, _SPOKES)
        other = left[(found != true[left, None]).any(axis=1)]
        boundary[other] = np.minimum(boundary[other], radius)
        same[left[(found == shown[left, None]).any(axis=1)]] = radius
    return boundary, same


def _tail(values: Floats) -> tuple[float, float]:
    """99th percentile and worst."""
    return (float(np.quantile(values, 0.99)), float(values.max())) if len(values) else (float("nan"), float("nan"))


def _share(flags: NDArray[np.bool_]) -> float:
    return float(flags.mean()) if len(flags) else float("nan")
