"""The params of a planet's whole ground, rivers included."""

from __future__ import annotations

from dataclasses import replace

from ...components import Terrain
from .drainage.climate import climate_params
from .height_params import TerrainParams, asked_for
from .rivers.source import RiverKey, source
from .vector_water.ground import mapped_ground

__all__ = ["dry_ground", "ground_params"]


def dry_ground(terrain: Terrain, radius_m: float) -> TerrainParams:
    """As TerrainParams.from_component, with what the vector map says; without the planet's own rivers."""
    if not terrain.vector_map:
        return TerrainParams.from_component(terrain, radius_m)
    plain = TerrainParams.from_component(terrain, radius_m, tell=False)
    found = mapped_ground(plain, terrain.vector_map, int(1e6 * terrain.height_map_most_mb), terrain.rivers)
    asked_for(found.real)
    return found


def ground_params(
    terrain: Terrain, radius_m: float, sea: bool = True, before: TerrainParams | None = None
) -> TerrainParams:
    """As `dry_ground`, with its rivers, which are solved if nobody has done so yet.

    sea: whether the planet has an Ocean; without one nothing rains. before: the ground so far, whose rivers stay while
    new ones are solved in the background (rivers/source.py).
    """
    found = dry_ground(terrain, radius_m)
    if terrain.rivers <= 0.0:
        return found
    key = RiverKey(found, climate_params(terrain, sea), terrain.drainage_cells, terrain.rivers, terrain.banks)
    return replace(found, rivers=source.now(key) if before is None else source.soon(key, before.rivers))
