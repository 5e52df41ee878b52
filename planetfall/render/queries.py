"""Questions about what a renderer drew: what a pixel shows, and how high the drawn ground is."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..engine.space import pixel_rays, ray_sphere_from
from ..scene.companions import bodies
from ..systems.terrain.system import TerrainSystem

if TYPE_CHECKING:
    from ..camera.camera import Camera
    from ..camera.views import View
    from ..engine.system import System
    from .renderer import Renderer

_NAMES = {1: "terrain", 2: "sea", 3: "props"}


def pick(renderer: Renderer, camera: Camera | View, x: float, y: float) -> tuple[NDArray[np.float64], str] | None:
    """See Renderer.pick."""
    width, height = renderer.size
    if not (0.0 <= x < width and 0.0 <= y < height):
        raise ValueError(f"pick: pixel ({x}, {y}) is outside the picture of {width} x {height}")
    column, row = int(x), int(y)
    arrays = renderer.render(camera, outputs=("position", "surface"))
    surface = int(arrays["surface"][row, column])
    if surface == 0:
        return None
    position = renderer.camera_state(camera).position_m + arrays["position"][row, column].astype(np.float64)
    return position, _NAMES.get(surface, "props")


def planet_at(renderer: Renderer, camera: Camera | View, x: float, y: float, time_s: float) -> str | None:
    """See Renderer.planet_at."""
    found = {body.name: body for body in bodies(renderer.scene, time_s)}
    handle = camera._planet_in(renderer.scene)
    home = found[renderer.scene.planet.name if handle is None else handle.name]
    state = renderer.camera_state(camera)
    look = home.axes @ pixel_rays(state, renderer.size, [(x, y)])[0]
    eye = home.outside(state.position_m)
    hits = {b.name: float(ray_sphere_from(eye - b.centre_m, look, b.radius_m).near_m) for b in found.values()}
    first = min(hits, key=lambda name: hits[name])
    return first if math.isfinite(hits[first]) else None


def statistics(systems: Iterable[System]) -> dict[str, int]:
    """Counts of the last frame, summed over systems."""
    total: dict[str, int] = {}
    for system in systems:
        for key, value in system.statistics().items():
            total[key] = total.get(key, 0) + value
    return total


def height_drawn(renderer: Renderer, directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """See Renderer.height_drawn: the triangle of the drawn mesh below each direction, intersected with its radius in
    f64."""
    system = renderer.system("terrain")
    if not isinstance(system, TerrainSystem):
        return np.full(len(directions), np.nan)
    unit = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    with renderer.current():
        index = renderer._view_index
        return system.backend.height_drawn(unit, renderer.views[index].proxy, index)
