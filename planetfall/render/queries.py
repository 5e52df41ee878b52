"""Questions about what a renderer drew: how high the drawn ground is, and how much was drawn."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..systems.terrain.system import TerrainSystem

if TYPE_CHECKING:
    from ..engine.system import System
    from .drawn_view import DrawnView
    from .planet import PlanetRenderer


def statistics(systems: Iterable[System]) -> dict[str, int]:
    """Counts of the last frame, summed over systems."""
    total: dict[str, int] = {}
    for system in systems:
        for key, value in system.statistics().items():
            total[key] = total.get(key, 0) + value
    return total


def height_drawn(planet: PlanetRenderer, view: DrawnView, directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """See Renderer.height_drawn: the triangle of the drawn mesh below each direction, intersected with its radius in
    f64. The context is current."""
    system = planet.system("terrain")
    if not isinstance(system, TerrainSystem):
        return np.full(len(directions), np.nan)
    unit = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    return system.backend.height_drawn(unit, view)
