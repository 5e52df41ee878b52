"""The params of a planet's whole ground, rivers included."""

from __future__ import annotations

from dataclasses import replace

from ...components import Terrain
from .drainage.climate import climate_params
from .height_params import TerrainParams
from .rivers.source import RiverKey, source

__all__ = ["ground_params"]


def ground_params(
    terrain: Terrain, radius_m: float, sea: bool = True, before: TerrainParams | None = None
) -> TerrainParams:
    """As TerrainParams.from_component, with its rivers, which are solved if nobody has done so yet.

    sea: whether the planet has an Ocean; without one nothing rains. before: the ground so far, whose rivers stay while
    new ones are solved in the background (rivers/source.py).
    """
    found = TerrainParams.from_component(terrain, radius_m)
    if terrain.rivers <= 0.0:
        return found
    key = RiverKey(found, climate_params(terrain, sea), terrain.drainage_cells, terrain.rivers)
    return replace(found, rivers=source.now(key) if before is None else source.soon(key, before.rivers))
