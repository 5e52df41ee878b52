"""River nodes as arrays: what carves the ground and holds the water."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["RiverNodes"]

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class RiverNodes:
    """Arrays (N,). A node and its `to` make a segment, a straight line along which everything is linear."""

    direction: Floats
    """(N, 3) unit"""
    to: NDArray[np.int32]
    """the node downstream; -1: none, a mouth"""
    level_m: Singles
    """of the water above the reference sphere, from 0 up, never below that of `to`; below the sea where rivers end"""
    half_width_m: Singles
    """of the water; 0: a valley without"""
    depth_m: Singles
    """in the middle"""
    flat_m: Singles
    """half width of the valley's flat floor, at least that of the water"""
    reach_m: Singles
    """distance from the line at which the valley ends, more than flat_m"""
    lake: NDArray[np.bool_]
    """a lake's; a segment is a lake where both ends are, and then both have the same level"""
    discharge_m3_s: Singles

    def __len__(self) -> int:
        return len(self.to)
