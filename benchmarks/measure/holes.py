"""Holes: pixels that show the background although their ray certainly meets the planet."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ... import Camera, Renderer
from ...engine.space import CameraState, pixel_rays

Floats = NDArray[np.float64]

ALTITUDES_M = (0.5, 1e8)
_EDGE_SHARE = 0.4
"""Of the cameras stand on an axis, an edge or a corner of the cube, or within a hair of one."""


@dataclass
class Holes:
    """What was looked at, and what was missing."""

    cameras: int = 0
    pixels: int = 0
    """That had to show something."""
    holes: int = 0
    where: list[str] = field(default_factory=list)
    """The first few."""


def must_hit(state: CameraState, size: tuple[int, int], radius_m: float, lowest_m: float) -> NDArray[np.bool_]:
    """Pixels (H, W) whose rays meet the sphere below all ground, by two pixels or more. None for a camera inside it."""
    rays = pixel_rays(state, size)
    inner, position = radius_m + lowest_m, state.position_m
    if float(np.linalg.norm(position)) <= inner:
        return np.zeros(rays.shape[:2], bool)
    ahead = -(rays @ position)
    nearest = np.sqrt(np.maximum((position @ position) - ahead * ahead, 0.0))
    pixel = max((state.tan_top - state.tan_bottom) / size[1], (state.tan_right - state.tan_left) / size[0])
    return (ahead > 0.0) & (nearest < inner - 2.0 * pixel * ahead - 1e-9 * ahead)


def find_holes(renderer: Renderer, cameras: int, rng: np.random.Generator, settle_share: float = 0.1) -> Holes:
    """Random cameras from 0.5 m to 1e8 m above ground and sea, looking anywhere at the planet.

    Each is a cut: the frame is looked at as it comes, before anything has streamed in. After a tenth of them, and in
    the four frames after each of these, while tiles stream in, the picture is looked at again.
    """
    found = Holes()
    for _ in range(cameras):
        camera = random_camera(renderer, rng)
        _look(renderer, camera, found)
        found.cameras += 1
        if rng.random() < settle_share:
            for _ in range(4):
                _look(renderer, camera, found)
            renderer.settle(camera)
            _look(renderer, camera, found)
    return found


def _look(renderer: Renderer, camera: Camera, found: Holes) -> None:
    out = renderer.render(camera, outputs=("surface",))
    state = renderer.camera_state(camera)
    planet = renderer.scene.planet
    height_field = planet.height_field()
    assert height_field is not None
    must = must_hit(state, renderer.size, planet.radius_m, height_field.lowest_m)
    missing = must & (out["surface"] == 0)
    found.pixels += int(must.sum())
    found.holes += int(missing.sum())
    if missing.any() and len(found.where) < 5:
        row, column = np.argwhere(missing)[0]
        found.where.append(
            f"pixel ({column}, {row}) of {int(missing.sum())} from {state.position_m.tolist()}"
            f" towards {state.forward.tolist()}, up {state.up.tolist()}"
        )


def random_camera(renderer: Renderer, rng: np.random.Generator) -> Camera:
    """Above all faces, edges, corners and poles; altitudes even in the logarithm."""
    zenith = rng.normal(size=3)
    if rng.random() < _EDGE_SHARE:
        zenith = rng.integers(-1, 2, 3).astype(float)
        if not zenith.any():
            zenith[2] = 1.0
        if rng.random() < 0.5:
            zenith = zenith + rng.normal(size=3) * 10.0 ** rng.uniform(-16.0, -3.0)
    zenith = zenith / np.linalg.norm(zenith)
    planet = renderer.scene.planet
    low, high = np.log10(ALTITUDES_M)
    above_m = 10.0 ** rng.uniform(low, high)
    position = zenith * (planet.radius_m + float(planet.surface_height_m(zenith[None])[0]) + above_m)
    side = np.cross(zenith, rng.normal(size=3))
    side /= np.linalg.norm(side)
    # From straight down to the horizon, which lies the deeper the higher the camera is.
    dip = np.arccos(np.clip(planet.radius_m / np.linalg.norm(position), 0.0, 1.0))
    down = dip + (np.pi / 2 - dip) * rng.random() ** 2
    forward = side * np.cos(down) - zenith * np.sin(down)
    up = zenith if rng.random() < 0.7 else rng.normal(size=3)
    return Camera(position, forward, up, fov_y_deg=float(rng.choice([20.0, 60.0, 90.0])))
