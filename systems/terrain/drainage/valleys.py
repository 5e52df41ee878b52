"""What the valleys of a planet's streams look like: how wide, how flat, and where they end at the shore."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ....engine.surface.noise import pcg3d
from ..height import height
from ..height_model import Model
from .carve import Carved, CellGround
from .network import Network
from .places import FINER
from .streams import FLAT_SHARE, MOUTH_PARTS, REACH_M, StreamCells, level_unit_m, mouth_directions, packed_discharge

__all__ = ["stream_cells"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

_LEAST_CELLS, _MOST_SHARE = 3.0, 1.0 / 13.0
"""Catchment, in mean cells, from which on there is a stream; more where so many of a planet's cells would have one
that memory would not do: Earth has them on 0.07 of all."""

_SPRING_REACH_M, _NARROW_REACH_M, _WIDE_REACH_M = 2000.0, 4000.0, 7000.0
_CANYON_REACH_M, _CANYON_FLAT_M = 1250.0, 120.0
_WIDE_CELLS = 10.0
"""Root of the catchment, in cells, at which a valley is half way from narrow to wide."""
_FLAT_BY_ROOT, _FLAT_SLOPE, _FLAT_CUT_M = 0.016, 0.003, 150.0
"""Half of a valley's floor by the root of its catchment, where it is much less steep and much less deep than these."""
_UNEVEN_FLAT, _UNEVEN_REACH = 0.5, 0.25
"""Valleys widen and narrow from node to node by up to these shares."""
_DRY_MM, _MOIST_MM = 50.0, 150.0
"""Runoff of a year: below the first valleys in high flat land are canyons, above the second none is."""
_LEAST_LAKE, _UNEVEN_LAKE = 0.25, 0.25
"""Of the widest lake: where hardly any ground of a cell is flooded, and by how much more or less at random."""
_CANYON_DEPTH_M = 80.0
"""From this depth on, wholly at three times as much."""


def stream_cells(network: Network, carved: Carved, ground: CellGround, relief_m: Floats, model: Model) -> StreamCells:
    """The streams of a network with these levels; relief_m (N,): of the ground in each cell."""
    grid, receiver = network.grid, network.receiver
    mean_m2 = 4.0 * np.pi * network.radius_m * network.radius_m / grid.count
    catchment_m2 = np.where(network.sea, 0.0, network.catchment_m2)
    most = min(int(_MOST_SHARE * grid.count), len(catchment_m2))
    least_m2 = max(_LEAST_CELLS * mean_m2, float(np.partition(catchment_m2, -most)[-most]))
    kept = ~network.sea & ((catchment_m2 >= least_m2) | carved.lake)
    # Below a lake its water goes on.
    for cells in _downstream(network):
        kept[receiver[cells[kept[cells]]]] = True
    kept &= ~network.sea
    index = np.flatnonzero(kept)
    to = receiver[index]
    spring = np.ones(len(receiver), dtype=bool)
    spring[to] = False
    spring &= kept & ~carved.lake
    # No river has cut the ground at its spring; a little below it, so that it lies in a hollow.
    level_m = np.where(spring, np.maximum(ground.low_m - relief_m, carved.level_m), carved.level_m)
    unit_m = level_unit_m(model.params.highest_m)
    level = np.rint(level_m / unit_m)
    places = network.places
    apart = _lengths(places[index] - places[to]) * network.radius_m
    slope = (level[index] - level[to]) * unit_m / apart
    flat, reach = _forms(
        network.cells[index],
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
    share = np.where(carved.lake[index], _lake_widths(carved, relief_m, network.cells)[index], share)
    depth = np.where(carved.lake, np.maximum(np.rint((carved.level_m - carved.floor_m) / unit_m), 1.0), 0.0)
    around = grid.neighbours(network.cells[index])
    return StreamCells(
        network.cells[index],
        np.argmax(around == network.cells[to][:, None], axis=1).astype(np.uint8),
        network.offset[index],
        np.minimum(level[index], 65535.0).astype(np.uint16),
        packed_discharge(network.discharge_m3_s[index]),
        np.rint(share * 255.0).astype(np.uint8),
        np.minimum(packed_reach, 255.0).astype(np.uint8),
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
    cells: NDArray[np.int32],
    catchment_m2: Floats,
    mean_m2: float,
    slope: Floats,
    cut_m: Floats,
    relief_m: Floats,
    runoff_mm: Floats,
) -> tuple[Floats, Floats]:
    """Half widths of the floor and reaches (N,), in metres on a planet of Earth's size."""
    root = np.sqrt(catchment_m2 / mean_m2)
    wide = root / (root + _WIDE_CELLS)
    reach = _NARROW_REACH_M + (_WIDE_REACH_M - _NARROW_REACH_M) * wide
    narrowed = (1.0 + slope / _FLAT_SLOPE) * (1.0 + cut_m / _FLAT_CUT_M)
    flat = _FLAT_BY_ROOT * 12e3 * root / narrowed
    uneven = _hashed(cells, 11)
    reach = reach * (1.0 + _UNEVEN_REACH * uneven[0])
    flat = np.minimum(flat * (1.0 + _UNEVEN_FLAT * uneven[1]), FLAT_SHARE * reach)
    dry = np.clip((_MOIST_MM - runoff_mm) / (_MOIST_MM - _DRY_MM), 0.0, 1.0)
    deep = np.clip((cut_m - _CANYON_DEPTH_M) / (2.0 * _CANYON_DEPTH_M), 0.0, 1.0)
    even = np.clip(2.0 - 2.0 * relief_m / np.maximum(cut_m, 1.0), 0.0, 1.0)
    canyon = dry * deep * even
    return (
        flat + (np.minimum(flat, _CANYON_FLAT_M) - flat) * canyon,
        reach + (_CANYON_REACH_M - reach) * canyon,
    )


def _lake_widths(carved: Carved, relief_m: Floats, cells: NDArray[np.int32]) -> Floats:
    """Shares (N,) of LAKE_CELLS: by how much of the cell's ground lies below the lake's level, as if its heights were
    spread evenly about their mean."""
    flooded = (carved.level_m - carved.floor_m) / np.maximum(relief_m, 1.0)
    flooded = np.minimum(np.maximum(0.5 * (flooded - FINER), 0.0), 1.0)
    uneven = 1.0 + _UNEVEN_LAKE * _hashed(cells, 12)[0]
    return np.minimum((_LEAST_LAKE + (1.0 - _LEAST_LAKE) * np.sqrt(flooded)) * uneven, 1.0)


def _hashed(cells: NDArray[np.int32], salt: int) -> list[Floats]:
    """Two numbers (N,) from -1 to 1 for each cell."""
    number = cells.astype(np.uint32)
    words = pcg3d(number, np.full_like(number, salt), np.zeros_like(number))
    return [(word >> np.uint32(8)).astype(np.float64) * 2.0**-23 - 1.0 for word in words[:2]]


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
