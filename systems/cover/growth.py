"""How well trees grow at a place: the float64 twin of what terrain/ground_at.glsl and material.glsl say of forests.

Without their noise, which follows the pixel: a tree stands where it stands, however far away the eye is.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ...components import Terrain

__all__ = ["Climate", "Growing", "GrowingGround", "ramp", "savanna"]

Floats = NDArray[np.float64]

_MEAN_MOISTURE = 0.41  # as systems/terrain/material.py takes it off
_LEAST_CLIMATE_M = 1.0
_BANK_WET = 0.4
"""Moisture that banks of rivers and lakes have more; as TERRAIN_BANK_WET of terrain/height.glsl."""
_SAVANNA_HUMID, _SAVANNA_WARM = (0.38, 0.46, 0.55, 0.49), (0.40, 0.60)
"""Between which savanna begins, and ends where forest does; as in assets/shaders/terrain/forest.glsl."""


class GrowingGround(Protocol):
    """What is asked of the ground: heights, and what only it knows of water and
    of forests on a map. Directions are unit vectors (N, 3)."""

    @property
    def radius_m(self) -> float: ...
    def height(self, directions: Floats) -> Floats: ...
    def moisture(self, directions: Floats) -> Floats: ...
    def beside_water(self, directions: Floats) -> Floats: ...
    def from_water_m(self, directions: Floats) -> Floats: ...
    def is_wet(self, directions: Floats, height_m: Floats) -> NDArray[np.bool_]: ...
    def wooded(self, directions: Floats) -> NDArray[np.bool_]: ...


def ramp(a: float, b: float, x: Floats) -> Floats:
    """0 at a, 1 at b, straight between; b may be the lower one."""
    return np.clip((x - a) / (b - a), 0.0, 1.0)


def _bell(x: Floats, centre: float, inverse_width: float) -> Floats:
    t = np.maximum(1.0 - ((x - centre) * inverse_width) ** 2, 0.0)
    return t * t


@dataclass(frozen=True)
class Climate:
    """Of places (N,): 0 at the snow line and 1 at the equator's sea; 0.3 a desert and 0.7 a forest."""

    warmth: Floats
    humidity: Floats


def savanna(climate: Climate) -> Floats:
    """0 elsewhere .. 1 where it is warm, and too dry for a forest."""
    begins, whole, ends, less = _SAVANNA_HUMID
    return (
        ramp(begins, whole, climate.humidity)
        * ramp(ends, less, climate.humidity)
        * ramp(*_SAVANNA_WARM, climate.warmth)
    )


CLIMATE = ("plants", "humidity", "snow_line_m", "snow_line_pole_m", "beach_height_m")
"""Fields of Terrain that Growing follows from; of its shape the ground has a revision of its own."""


@dataclass(frozen=True)
class Growing:
    """What of the component Terrain decides where trees grow."""

    plants: float
    humidity: float
    snow_line_m: float
    snow_line_rise_m: float
    lowest_m: float
    """above the sea and its beach"""
    beach_m: float = 0.0
    """how high the beach is, below that"""
    savanna: float = 0.0
    """share of the places that have a tree where it is warm and too dry for a forest"""
    riparian: float = 0.0
    """how much wetter banks of rivers and lakes are"""

    @property
    def sea_m(self) -> float:
        """Level of the sea; far below all ground where there is none."""
        return self.lowest_m - self.beach_m

    @classmethod
    def of(cls, terrain: Terrain, sea_level_m: float | None, savanna: float = 0.0, riparian: float = 0.0) -> Growing:
        """sea_level_m: None where there is no sea. savanna, riparian: as Cover has them."""
        return cls(
            terrain.plants,
            terrain.humidity - _MEAN_MOISTURE,
            terrain.snow_line_m,
            terrain.snow_line_pole_m - terrain.snow_line_m,
            -np.inf if sea_level_m is None else sea_level_m + terrain.beach_height_m,
            terrain.beach_height_m,
            savanna,
            riparian,
        )

    def climate(self, ground: GrowingGround, directions: Floats, height_m: Floats) -> Climate:
        """As ground_climate() has it, without chance."""
        sine = np.abs(directions[:, 2])
        moisture = ground.moisture(directions)
        if self.riparian > 0.0:
            moisture = np.minimum(moisture + _BANK_WET * self.riparian * ground.beside_water(directions), 1.0)
        humidity = self.humidity + 0.9 * moisture
        humidity += 0.30 * _bell(sine, 0.0, 3.6) - 0.34 * _bell(sine, 0.42, 3.2) + 0.16 * _bell(sine, 0.85, 2.2)
        return Climate(self.warmth(sine, height_m), humidity)

    def warmth(self, sine: Floats, height_m: Floats) -> Floats:
        """(N,) of the climate; sine: of the latitude, either sign."""
        line = self.snow_line_m + self.snow_line_rise_m * sine**2 * (0.4 + 0.6 * np.abs(sine))
        return (line - height_m) / max(-self.snow_line_rise_m, _LEAST_CLIMATE_M)

    def woods(self, climate: Climate) -> Floats:
        """0 none .. 1 a forest: growth.trees of terrain/material.glsl, and the savanna's of terrain/forest.glsl."""
        return self._growing(climate) * np.maximum(self._wooded(climate), self.savanna * savanna(climate))

    def shrubs(self, climate: Climate) -> Floats:
        """0 none .. 0.55 under the trees of a forest: growth.shrubs of terrain/material.glsl."""
        return self._growing(climate) * (0.10 + 0.45 * self._wooded(climate))

    def _growing(self, climate: Climate) -> Floats:
        return ramp(0.25, 0.55, climate.humidity) * self.plants

    @staticmethod
    def _wooded(climate: Climate) -> Floats:
        return ramp(0.50, 0.72, climate.humidity) * ramp(0.15, 0.28, climate.warmth)
