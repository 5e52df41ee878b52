"""Rivers and lakes as nodes on a planet, each with the next one downstream."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["RiverNodes"]

Singles = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class RiverNodes:
    """Arrays (N,). A node and the one downstream make a line; what follows changes evenly along it."""

    direction: NDArray[np.float64]
    """(N, 3) unit"""
    to: NDArray[np.int32]
    """the node downstream; -1: none"""
    level_m: Singles
    """of the water above the reference sphere, never below that of `to`"""
    half_width_m: Singles
    """of the water; 0 in a dry valley"""
    depth_m: Singles
    """in the middle"""
    flat_m: Singles
    """half width of the valley's flat floor"""
    reach_m: Singles
    """distance from the line at which the valley ends, more than flat_m"""
    lake: NDArray[np.bool_]
    """a line is a lake's if both its nodes are"""
    discharge_m3_s: Singles
