"""The cells that rivers run through, with what their valleys look like, in few bits.

Everything is kept as the whole numbers that are written to disk, and read from these alone: what comes from a file has
the same bits as what has just been solved.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "FLAT_SHARE",
    "LAKE_CELLS",
    "MOUTH_PARTS",
    "REACH_M",
    "StreamCells",
    "level_unit_m",
    "mouth_directions",
    "packed_discharge",
    "unpacked_discharge",
]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

REACH_M = 40.0
"""Reaches are kept in these on a planet of Earth's size, up to 10 km."""
FLAT_SHARE = 0.45
"""No valley's floor is wider than this share of the valley."""
LAKE_CELLS = 0.6
"""A lake's node is no wider to either side than this, in cells."""
MOUTH_PARTS = 255
"""Of the way from a stream's last cell to the middle of the sea's: by these the shore's place is told."""


@dataclass(frozen=True, eq=False)
class StreamCells:
    """Cells of land with a stream or a lake, (N,), in the order of their numbers."""

    cells: NDArray[np.int32]
    step: NDArray[np.uint8]
    """which of the eight neighbours water goes to"""
    offset: NDArray[np.int8]
    """(N, 2) see places.py"""
    level: NDArray[np.uint16]
    """of water, in level_unit_m"""
    discharge: NDArray[np.uint16]
    """m^3/s: the upper half of a float32"""
    flat: NDArray[np.uint8]
    """half of the valley's floor, in 255ths of FLAT_SHARE of its reach; in a lake half of the water, in 255ths of
    LAKE_CELLS"""
    reach: NDArray[np.uint8]
    """from the river to the valley's edge, in REACH_M"""
    lake: NDArray[np.uint16]
    """depth of a lake in level_unit_m, from 1 up; 0: none"""
    mouth: NDArray[np.uint8]
    """where the shore is on the way to the sea's cell, in MOUTH_PARTS; 0: the stream goes on on land"""


def level_unit_m(highest_m: float) -> float:
    """In what levels are kept on a planet with no ground above that: a power of two, 0.25 m on Earth."""
    return math.ldexp(1.0, math.frexp(max(highest_m, 1e-3) / 65535.0)[1])


def packed_discharge(discharge_m3_s: Floats) -> NDArray[np.uint16]:
    """To 8 bits of mantissa, rounded down: a river never has less than those that join it."""
    return (discharge_m3_s.astype(np.float32).view(np.uint32) >> np.uint32(16)).astype(np.uint16)


def unpacked_discharge(packed: NDArray[np.uint16]) -> NDArray[np.float32]:
    """In m^3/s."""
    return (packed.astype(np.uint32) << np.uint32(16)).view(np.float32)


def mouth_directions(near: Floats, far: Floats, parts: Floats) -> Floats:
    """Unit directions (N, 3) on the way from near to far (N, 3), by parts (N,) of MOUTH_PARTS."""
    share = (parts * (1.0 / MOUTH_PARTS))[:, None]
    x, y, z = (near * (1.0 - share) + far * share).T
    return np.stack([x, y, z], axis=1) / np.sqrt(x * x + y * y + z * z)[:, None]
