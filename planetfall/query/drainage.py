"""Where the water of a planet's land goes: catchments, and the largest rivers by name of a number."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..components import Ocean, Planet, Terrain
from ..systems.terrain.drainage.climate import climate_params
from ..systems.terrain.drainage.network import Network
from ..systems.terrain.drainage.stored import network_of
from ..systems.terrain.height import TerrainParams

if TYPE_CHECKING:
    from ..scene.handle import Parts

__all__ = ["Drainage", "River", "drainage_at", "network_below", "rivers_of"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Drainage:
    """Where water of some places goes. In the sea: 0, 0, no way, -1."""

    catchment_m2: Floats
    """(N,) land whose water comes through the place's cell"""
    discharge_m3_s: Floats
    """(N,) of that water, mean of a year"""
    downstream: Floats
    """(N, 3) unit, level: from the place's cell to the one that its water goes to"""
    basin: NDArray[np.int64]
    """(N,) places whose water comes to the sea at one place have the same number"""


@dataclass(frozen=True)
class River:
    """From the spring to the sea, or to a larger river."""

    number: int
    """0 is the one with the most water"""
    into: int | None
    """number of the river it joins; None: the sea, or a river that is not among those asked for"""
    reaches_sea: bool
    length_m: float
    discharge_m3_s: float
    """where it ends, mean of a year"""
    catchment_m2: float
    path: Floats
    """(K, 3) unit directions, one a cell, downstream"""

    @property
    def source(self) -> Floats:
        """Direction (3,) of its spring."""
        return self.path[0]

    @property
    def mouth(self) -> Floats:
        """Direction (3,) of its end."""
        return self.path[-1]


def network_below(planet: Parts, cells: int | None = None, progress: Callable[[float], None] | None = None) -> Network:
    """The rivers of a scene's planet; solved, or from the user's cache folder. cells: the terrain's own by default."""
    terrain, shape = planet.get(Terrain), planet.get(Planet)
    if terrain is None or shape is None:
        raise ValueError("drainage: the planet has no Terrain, so there is nothing that water could run down")
    params = TerrainParams.from_component(terrain, shape.radius_m)
    return network_of(
        params, climate_params(terrain, planet.get(Ocean) is not None), cells or terrain.drainage_cells, progress
    )


def drainage_at(network: Network, directions: Floats) -> Drainage:
    """At unit directions (N, 3): of the cell that each lies in."""
    index = network.index[network.grid.locate(directions)]
    land = (index >= 0) & ~network.sea[np.maximum(index, 0)]
    cell = np.where(land, index, 0)
    here, there = network.places[cell], network.places[network.receiver[cell]]
    way = there - here * (there * here).sum(axis=1)[:, None]
    length = np.linalg.norm(way, axis=1)[:, None]
    return Drainage(
        np.where(land, network.catchment_m2[cell], 0.0),
        np.where(land, network.discharge_m3_s[cell], 0.0),
        np.where(land[:, None], way / np.maximum(length, 1e-300), 0.0),
        np.where(land, network.mouth[cell], -1),
    )


def rivers_of(network: Network, count: int) -> list[River]:
    """The `count` rivers with the most water, the largest first."""
    if isinstance(count, bool) or not isinstance(count, int) or count < 0:
        raise ValueError(f"rivers: count: expected a whole number from 0 up, found {count!r}")
    found = []
    for number, stream in enumerate(network.streams(count)):
        path = network.places[stream.cells]
        angles = 2.0 * np.arcsin(0.5 * np.linalg.norm(np.diff(path, axis=0), axis=1))
        last, end = stream.cells[-2], stream.cells[-1]
        found.append(
            River(
                number,
                None if stream.into < 0 else stream.into,
                bool(network.sea[end]),
                float(angles.sum()) * network.radius_m,
                float(network.discharge_m3_s[last]),
                float(network.catchment_m2[last]),
                path,
            )
        )
    return found
