"""The ground with a vector map on it: its water as samples of ground and lines of rivers and lakes, its forests as
polygons."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ....engine.real_ground.lattice import directions_at
from ....engine.real_ground.pages import PageLevel
from ....engine.real_ground.polygons import Polygons
from ....engine.real_ground.real_ground import RealGround
from ....engine.real_ground.resident import MOST_LEVELS
from ....engine.real_ground.tile_files import TileError
from ....engine.real_ground.vector_file import VectorMap, vector_map, vector_stamp
from ..height import height
from ..height_params import TerrainParams
from .bodies import lakes_of, seas_of
from .lines import water_table
from .raster import water_levels
from .streams import levelled, widened

__all__ = ["mapped_ground"]

Floats = NDArray[np.float64]


def mapped_ground(params: TerrainParams, path: str, most_bytes: int, rivers: float) -> TerrainParams:
    """params with the map at `path`, made once for each ground. most_bytes: as Terrain.height_map_most_mb says.
    rivers: as Terrain has them. TileError says what is wrong with the file, or doesn't go with it."""
    if vector_map(path).watered:
        where = f"Terrain.vector_map: {path} has water"
        if rivers > 0.0:
            raise TileError(f"{where}, and Terrain.rivers is {rivers:g}: rivers would be there twice; set it to 0")
        if params.craters > 0.0:
            raise TileError(f"{where}, and Terrain.craters is {params.craters:g}; set it to 0")
        if params.height_map is not None:
            raise TileError(
                f"{where}, and Terrain.height_map is one map of all the planet; expected a folder of tiles, or none"
            )
    return _mapped(params, path, vector_stamp(path), most_bytes)


@lru_cache(maxsize=2)
def _mapped(params: TerrainParams, path: str, _stamp: tuple[str, int, int], most_bytes: int) -> TerrainParams:
    # Not forgotten with tiles: planets of a scene are asked for by turns.
    found = vector_map(path)
    woods = _woods(found) if found.forests else None
    if not found.watered:
        return replace(params, woods=woods)
    return _watered(replace(params, woods=woods), params, found, most_bytes)


@lru_cache(maxsize=2)
def _woods(found: VectorMap) -> Polygons:
    """The same ones for all grounds, so that their picture is made once. On whichever turns around the world their
    bounds are narrowest: the RFC has files cut at the date line."""
    forests = [rings for patch in found.forests for rings in patch.polygons]
    forests.sort(key=lambda rings: float(rings[0][:, 0].min()))
    west, east = (np.array([f(rings[0][:, 0]) for rings in forests]) for f in (np.min, np.max))
    east = np.maximum.accumulate(east)
    gaps = np.append(west[1:] - east[:-1], west[0] + 360.0 - east[-1])
    # Those west of the widest gap come after the others.
    turned = int(np.argmax(gaps)) + 1 if gaps.max() > gaps[-1] else 0
    later = [tuple(ring + np.array([360.0, 0.0]) for ring in rings) for rings in forests[:turned]]
    return Polygons([*forests[turned:], *later])


def _watered(params: TerrainParams, plain: TerrainParams, found: VectorMap, most_bytes: int) -> TerrainParams:
    radius_m = params.radius_m

    def ground(latitude_deg: Floats, longitude_deg: Floats) -> Floats:
        return height(np.ascontiguousarray(directions_at(latitude_deg, longitude_deg).T), plain)

    halves, areas = widened(found.rivers, found.banks, radius_m)
    lakes = lakes_of([*found.lakes, *areas], ground, radius_m)
    ways = levelled(found.rivers, halves, lakes, ground, radius_m)
    what = f"Terrain.vector_map: {found.path}"
    table = water_table(lakes, ways, ground, radius_m, params.seed, what)
    levels = water_levels([*lakes, *seas_of(found)], table, ground, radius_m, most_bytes // 2, what)
    return replace(params, water=table, real=_over(params.real, levels, what))


def _over(real: RealGround | None, levels: list[tuple[PageLevel, int]], what: str) -> RealGround | None:
    """Levels over those of tiles."""
    if not levels:
        return real
    found, factors = (tuple(v) for v in zip(*levels, strict=True))
    low = min(float(level.heights.min()) for level in found)
    high = max(float(level.heights.max()) for level in found)
    room = 0.05 * max(high - low, 1.0)
    if real is None:
        return RealGround(found, factors, (0,) * len(found), low - room, high + room)
    if len(real.levels) + len(found) > MOST_LEVELS:
        raise TileError(
            f"{what}: with the tiles of Terrain.height_map these are {len(real.levels) + len(found)} levels; expected "
            f"at most {MOST_LEVELS}: remove the sets that others cover"
        )
    return replace(
        real,
        levels=(*found, *real.levels),
        factors=(*factors, *real.factors),
        finest_of=(*(0,) * len(found), *(k + len(found) for k in real.finest_of)),
        lowest_m=min(real.lowest_m, low - room),
        highest_m=max(real.highest_m, high + room),
    )
