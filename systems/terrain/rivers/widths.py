"""How wide and deep rivers and lakes are: rows of numbers that are linear along a line from node to node."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..drainage.cells import CellGrid
from ..drainage.streams import FLAT_SHARE, LAKE_CELLS, REACH_M, StreamCells, level_unit_m, unpacked_discharge
from ..height_params import TerrainParams

__all__ = [
    "DEPTH",
    "FLAT",
    "HALF_WIDTH",
    "LEVEL",
    "REACH",
    "ROWS",
    "WIDTH_BY_ROOT",
    "half_width_m",
    "lake_rows",
    "narrowest",
    "river_rows",
]

Floats = NDArray[np.float64]

LEVEL, HALF_WIDTH, DEPTH, FLAT, REACH = range(5)
"""Rows of (6, N), and the last: discharge."""
ROWS = ("level_m", "half_width_m", "depth_m", "flat_m", "reach_m", "discharge_m3_s")

WIDTH_BY_ROOT = 7.2
"""Metres of width by the root of m^3/s; depth is 0.27 Q^0.39 m: downstream hydraulic geometry (Leopold and Maddock
1953), the numbers by Moody and Troutman (2002) for rivers of all sizes."""
_LEAST_M3_S = 1.0
"""Below this the valley is dry."""
_BANKS = 1.25
"""Least half width of a valley's floor, in half widths of its river."""
_NARROWEST_M = 1250.0
"""Reach of the narrowest valleys, canyons, on a planet of Earth's size."""
_LAKE_SHORE_M = 3000.0
"""From a lake's edge to where the ground is as it was, on a planet of Earth's size."""


def river_rows(streams: StreamCells, params: TerrainParams, strength: float) -> Floats:
    """(6, N), as if there were no lakes. strength: multiplies the discharge."""
    discharge = unpacked_discharge(streams.discharge).astype(np.float64) * strength
    wet = discharge >= _LEAST_M3_S
    half_width = half_width_m(discharge)
    depth = np.where(wet, _depth_m(discharge), 0.0)
    reach = streams.reach * (REACH_M * params.scale)
    flat = np.where(streams.lake > 0, 0.0, streams.flat * (FLAT_SHARE / 255.0) * reach)
    flat = np.maximum(flat, _BANKS * half_width)
    reach = np.maximum(reach, flat * (1.0 / FLAT_SHARE))
    level = streams.level.astype(np.float64) * level_unit_m(params.highest_m)
    return np.stack([level, half_width, depth, flat, reach, discharge])


def lake_rows(grid: CellGrid, streams: StreamCells, params: TerrainParams, rivers: Floats) -> Floats:
    """(6, N), those of `rivers` (6, N) but for the lakes' nodes."""
    rows, lake = rivers.copy(), np.flatnonzero(streams.lake)
    cell_m = params.radius_m * np.sqrt(4.0 * np.pi / grid.count)
    half_width = np.maximum(streams.flat[lake] * (LAKE_CELLS / 255.0) * cell_m, rivers[HALF_WIDTH, lake])
    rows[HALF_WIDTH, lake] = half_width
    rows[DEPTH, lake] = np.maximum(streams.lake[lake] * level_unit_m(params.highest_m), rivers[DEPTH, lake])
    rows[FLAT, lake] = half_width
    rows[REACH, lake] = half_width + _LAKE_SHORE_M * params.scale
    return rows


def narrowest(half_width: Floats, scale: float) -> tuple[Floats, Floats]:
    """Half width of the floor, and reach, of the narrowest valleys that hold rivers (N,). scale: of valleys."""
    flat = _BANKS * half_width
    return flat, np.maximum(flat * (1.0 / FLAT_SHARE), _NARROWEST_M * scale)


def half_width_m(discharge: Floats) -> Floats:
    """Of rivers (N,) with so much water, in m^3/s: 0 where a valley is dry."""
    return np.where(discharge >= _LEAST_M3_S, 0.5 * WIDTH_BY_ROOT * np.sqrt(discharge), 0.0)


def _depth_m(discharge: Floats) -> Floats:
    """0.27 Q^(25/64), from roots alone: every machine rounds those alike."""
    fourth = np.sqrt(np.sqrt(discharge))
    eighth = np.sqrt(fourth)
    return 0.27 * fourth * eighth * np.sqrt(np.sqrt(np.sqrt(eighth)))
