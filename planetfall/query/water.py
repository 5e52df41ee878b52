"""Where water lies: rivers and lakes, and the calm sea."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..systems.terrain.rivers.valleys import waters

if TYPE_CHECKING:
    from ..systems.terrain.height import TerrainField

__all__ = ["Water", "water_at"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Water:
    """Water over some places of the ground."""

    level_m: Floats
    """(N,) of the calm surface above the reference sphere; NaN where the ground is dry"""
    depth_m: Floats
    """(N,) of the ground below that; 0 where it is dry"""
    current_m_s: Floats
    """(N, 3) how fast water flows, and where to, in planet axes: along the banks, fastest in the middle, millimetres a
    second through lakes to where they drain, 0 in the sea"""


def water_at(field: TerrainField, sea_level_m: float | None, directions: Floats) -> Water:
    """Over the ground in unit directions (N, 3). sea_level_m: None where there is no sea."""
    height = field.height(directions)
    level, current = np.full(len(directions), np.nan), np.zeros((len(directions), 3))
    if sea_level_m is not None:
        level[height < sea_level_m] = sea_level_m
    rivers = field.params.waters
    if rivers is not None:
        found = waters(rivers, directions.T * field.radius_m)
        wet = (found.beyond_m < 0.0) & (found.level_m > height)
        # A river's mouth lies under the sea as well.
        wet &= ~(level > found.level_m)
        level[wet], current[wet] = found.level_m[wet], found.current_m_s.T[wet]
    depth = np.where(np.isnan(level), 0.0, np.nan_to_num(level) - height)
    return Water(level, depth, current)
