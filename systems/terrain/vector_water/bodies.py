"""Still water of a vector map: areas with one level each, and the ground that is asked for it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....engine.real_ground.polygons import Polygons
from ....engine.real_ground.vector_file import Patch, VectorMap

__all__ = ["Body", "Ground", "along", "lakes_of", "metres_per_deg", "seas_of"]

Floats = NDArray[np.float64]
Ground = Callable[[Floats, Floats], Floats]
"""Heights (N,) at latitudes and longitudes (N,), degrees."""

LAKE_M, SEA_M = 6.0, 12.0
"""Depths away from the shore."""
_RIM_M = 60.0
"""Heights along a rim are asked for so far apart, or closer."""
_MOST_RIM = 40_000


@dataclass(eq=False)
class Body:
    """Water with one level. land: what is taken out of it; band: it is known near its shore alone, of the other side of
    an island's."""

    area: Polygons
    level_m: float
    depth_m: float
    sea: bool = False
    land: Polygons | None = None
    band: bool = False


def metres_per_deg(radius_m: float, latitude_deg: float) -> tuple[float, float]:
    """Of longitude and of latitude there."""
    per = float(np.radians(1.0)) * radius_m
    return per * max(float(np.cos(np.radians(latitude_deg))), 1e-6), per


def along(edges: Floats, apart_deg: float, most: int) -> Floats:
    """(N, 2) points along edges (E, 4), apart_deg from each other at most, or all equally farther where they would be
    more than `most`; their first ends are among them."""
    length = np.hypot(edges[:, 2] - edges[:, 0], edges[:, 3] - edges[:, 1])
    apart = max(apart_deg, float(length.sum()) / max(most - len(edges), 1)) if len(edges) else apart_deg
    many = np.maximum(np.ceil(length / apart), 1.0).astype(np.int64)
    edge = np.repeat(np.arange(len(edges)), many)
    share = (np.arange(len(edge)) - np.repeat(np.cumsum(many) - many, many)) / many[edge]
    return edges[edge, :2] + share[:, None] * (edges[edge, 2:] - edges[edge, :2])


def rim_level(area: Polygons, ground: Ground, radius_m: float) -> float:
    """The lowest height of the ground along a rim."""
    apart_deg = float(np.degrees(_RIM_M / radius_m))
    points = along(area.edges, apart_deg, _MOST_RIM)
    return float(ground(points[:, 1], points[:, 0]).min())


def lakes_of(patches: list[Patch], ground: Ground, radius_m: float) -> list[Body]:
    """One for each, at the level that the file says, or the lowest that the ground has along its rim."""
    found = []
    for patch in patches:
        area = Polygons(patch.polygons)
        level = rim_level(area, ground, radius_m) if patch.level_m is None else patch.level_m
        found.append(Body(area, level, LAKE_M))
    return found


def seas_of(map_: VectorMap) -> list[Body]:
    """Sea at level 0, and the land of islands next to it."""
    islands = Polygons(rings for patch in map_.islands for rings in patch.polygons) if map_.islands else None
    found = []
    if map_.seas:
        area = Polygons(rings for patch in map_.seas for rings in patch.polygons)
        found.append(Body(area, 0.0, SEA_M, sea=True, land=islands))
    if islands is not None:
        found.append(Body(islands, 0.0, SEA_M, sea=True, band=True))
    return found
