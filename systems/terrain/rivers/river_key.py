"""What a planet's rivers depend on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..drainage.climate import ClimateParams

if TYPE_CHECKING:
    from ..height_params import TerrainParams

__all__ = ["RiverKey"]


@dataclass(frozen=True)
class RiverKey:
    """All that a planet's rivers depend on."""

    params: TerrainParams
    """without rivers"""
    climate: ClimateParams
    cells: int
    strength: float
    banks: float = 1.0
    """how uneven these are"""
