"""CoverSampler: the trees and shrubs of a planet, in float64 and without OpenGL."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..components import Cover, Ocean, Planet, Terrain
from ..engine.world import MissingError
from ..systems.cover.growth import Growing
from ..systems.cover.near import plots_within
from ..systems.cover.stand import LAYERS, Plants, plants_in, plot_level
from ..systems.terrain.ground_params import ground_params
from ..systems.terrain.height import TerrainField
from .terrain import checked_directions

if TYPE_CHECKING:
    from ..scene.scene import PlanetHandle, Scene

__all__ = ["CoverSampler"]

MOST_M = 20_000.0
"""Radius within which a sampler looks for trees: some twenty million places, in forest."""
_BLOCK = 128
"""Plots made at once: some 60 MB."""


class CoverSampler:
    """Where trees and shrubs stand: a snapshot of the scene when it was made. They are those that are drawn."""

    def __init__(self, scene: Scene, planet: PlanetHandle | str | None = None) -> None:
        """planet: one of scene.planets, or its name; its first one by default. ValueError without a Cover."""
        if isinstance(planet, str):
            if planet not in scene.planets:
                raise ValueError(f"CoverSampler: planet must be one of scene.planets, found {planet!r}")
            planet = scene.planets[planet]
        handle = planet or scene.planet
        try:
            terrain, cover = handle[Terrain], handle[Cover]
        except (KeyError, MissingError):
            raise ValueError(
                "CoverSampler: the planet needs the components Terrain and Cover; add one with "
                "scene.planet.add(pf.Cover())"
            ) from None
        scene.validate()
        ocean = handle.get(Ocean)
        self._field = TerrainField(ground_params(terrain, handle[Planet].radius_m, ocean is not None))
        self._growing = Growing.of(terrain, None if ocean is None else ocean.sea_level_m)
        self._cover, self._seed = replace(cover), terrain.seed

    def within(self, direction: ArrayLike, radius_m: float) -> Plants:
        """The trees and shrubs within radius_m along the ground of the place in `direction` (3,) from the planet's
        centre.

        ValueError for a radius that is not above 0 and at most 20 km.
        """
        if not 0.0 < radius_m <= MOST_M:
            raise ValueError(f"radius_m: expected metres above 0 and at most {MOST_M:g}, found {radius_m!r}")
        middle = checked_directions("direction", np.atleast_2d(np.asarray(direction, dtype=np.float64)))
        if len(middle) != 1:
            raise ValueError(f"direction: expected one, (3,), found {len(middle)}")
        radius = self._field.radius_m
        plots = plots_within(middle[0], radius_m / radius, plot_level(radius))
        parts = []
        for first in range(0, len(plots), _BLOCK):
            block = plots[first : first + _BLOCK]
            found = Plants.of(
                [
                    plants
                    for layer in LAYERS
                    for plants in plants_in(block, self._field, self._growing, self._cover, self._seed, layer)
                ]
            )
            parts.append(found.only(_along(found.positions_m, middle[0], radius) <= radius_m))
        return Plants.of(parts)


def _along(positions_m: NDArray[np.float64], direction: NDArray[np.float64], radius_m: float) -> NDArray[np.float64]:
    away = positions_m / np.linalg.norm(positions_m, axis=1, keepdims=True) - direction
    return 2.0 * radius_m * np.arcsin(np.minimum(0.5 * np.linalg.norm(away, axis=1), 1.0))
