"""What the valleys of a planet's streams look like: how wide, how flat, and where they end at the shore."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..height import height
from ..height_model import Model
from .carve import Carved, CellGround
from .cells import CellGrid
from .network import Network
from .places import place_directions
from .streams import FLAT_SHARE, LEVEL_M, MOUTH_PARTS, REACH_M, StreamCells, mouth_directions, packed_discharge

__all__ = ["stream_cells"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

_LEAST_CELLS = 2.5
"""Catchment, in mean cells, from which on there is a stream."""

_SPRING_REACH_M, _NARROW_REACH_M, _WIDE_REACH_M = 2000.0, 4000.0, 7000.0
_CANYON_REACH_M, _CANYON_FLAT_M = 1250.0, 120.0
_WIDE_CELLS = 10.0
"""Root of the catchment, in cells, at which a valley is half way from narrow to wide."""
_FLAT_BY_ROOT, _FLAT_SLOPE = 0.016, 0.003
"""Half of a valley's floor by the root of its catchment, where it is much less steep than this."""
_DRY_MM, _MOIST_MM = 50.0, 150.0
"""Runoff of a year: below the first valleys in high flat land are canyons, above the second none is."""
_CANYON_DEPTH_M = 150.0
"""From this depth on, wholly at three times as much."""


def stream_cells(network: Network, carved: Carved, ground: CellGround, relief_m: Floats, model: Model) -> StreamCells:
    """The streams of a network with these levels; relief_m (N,): of the ground in each cell."""
    grid, receiver = network.grid, network.receiver
    mean_m2 = 4.0 * np.pi * network.radius_m * network.radius_m / grid.count
    kept = ~network.sea & ((network.catchment_m2 >= _LEAST_CELLS * mean_m2) | carved.lake)
    # Below a lake its water goes on.
    for cells in _downstream(network):
        kept[receiver[cells[kept[cells]]]] = True
    kept &= ~network.sea
    index = np.flatnonzero(kept)
    to = receiver[index]
    spring = np.ones(len(receiver), dtype=bool)
    spring[to] = False
    level = np.rint(
        np.where(spring & ~carved.lake & kept, np.maximum(ground.low_m, carved.level_m), carved.level_m) / LEVEL_M
    )
    places = network.places
    apart = _lengths(places[index] - places[to]) * network.radius_m
    slope = (level[index] - level[to]) * LEVEL_M / apart
    flat, reach = _forms(
        network.catchment_m2[index],
        mean_m2,
        slope,
        np.maximum(ground.low_m - carved.level_m, 0.0)[index],
        relief_m[index],
        network.runoff_mm[index],
    )
    reach = np.where(spring[index], _SPRING_REACH_M, reach)
    flat = np.where(spring[index], 0.0, flat)
    packed_reach = np.rint(reach / REACH_M)
    share = np.minimum(flat / (FLAT_SHARE * REACH_M * packed_reach), 1.0)
    depth = np.where(carved.lake, np.maximum(np.rint((carved.level_m - carved.floor_m) / LEVEL_M), 1.0), 0.0)
    around = grid.neighbours(network.cells[index])
    return StreamCells(
        network.cells[index],
        np.argmax(around == network.cells[to][:, None], axis=1).astype(np.uint8),
        network.place[index],
        np.minimum(level[index], 65535.0).astype(np.uint16),
        packed_discharge(network.discharge_m3_s[index]),
        np.rint(share * 255.0).astype(np.uint8),
        packed_reach.astype(np.uint8),
        np.minimum(depth[index], 65535.0).astype(np.uint16),
        _mouths(network, index, model),
    )


def _downstream(network: Network) -> list[Indices]:
    """Cells by steps from the sea, the furthest first."""
    flow = network.flow
    return [flow.order[a:b] for a, b in zip(flow.starts[-2:0:-1], flow.starts[:1:-1], strict=True)]


def _lengths(vectors: Floats) -> Floats:
    x, y, z = vectors.T
    return np.sqrt(x * x + y * y + z * z)


def _forms(
    catchment_m2: Floats, mean_m2: float, slope: Floats, cut_m: Floats, relief_m: Floats, runoff_mm: Floats
) -> tuple[Floats, Floats]:
    """Half widths of the floor and reaches (N,), in metres on a planet of Earth's size."""
    root = np.sqrt(catchment_m2 / mean_m2)
    wide = root / (root + _WIDE_CELLS)
    reach = _NARROW_REACH_M + (_WIDE_REACH_M - _NARROW_REACH_M) * wide
    flat = np.minimum(_FLAT_BY_ROOT * 12e3 * root / (1.0 + slope / _FLAT_SLOPE), FLAT_SHARE * reach)
    dry = np.clip((_MOIST_MM - runoff_mm) / (_MOIST_MM - _DRY_MM), 0.0, 1.0)
    deep = np.clip((cut_m - _CANYON_DEPTH_M) / (2.0 * _CANYON_DEPTH_M), 0.0, 1.0)
    even = np.clip(2.0 - 2.0 * relief_m / np.maximum(cut_m, 1.0), 0.0, 1.0)
    canyon = dry * deep * even
    return (
        flat + (np.minimum(flat, _CANYON_FLAT_M) - flat) * canyon,
        reach + (_CANYON_REACH_M - reach) * canyon,
    )


def _mouths(network: Network, index: Indices, model: Model) -> NDArray[np.uint8]:
    """Where the full ground first lies below the sea on the way from a stream's last cell to the sea's cell."""
    found = np.zeros(len(index), dtype=np.uint8)
    last = np.flatnonzero(network.sea[network.receiver[index]])
    here, there = index[last], network.receiver[index[last]]
    near = network.places[here]
    far = network.directions[there]
    # From the sea's end, where ground is below 0: halved eight times, always the half with a shore in it.
    low, high = np.zeros(len(last)), np.full(len(last), float(MOUTH_PARTS))
    for _ in range(8):
        middle = np.floor(0.5 * (low + high))
        wet = height(mouth_directions(near, far, middle), model) <= 0.0
        low, high = np.where(wet, low, middle), np.where(wet, middle, high)
    found[last] = np.maximum(high, 1.0).astype(np.uint8)
    return found
