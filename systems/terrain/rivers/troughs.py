"""Troughs: valleys that glaciers of an ice age have filled have wide floors and steep sides, the shape of a U.

The snow line lay a kilometre lower then (Porter, Quaternary Science Reviews 20, 2001). A valley was filled where it
begins above that line in mountains, down to where its ice melted, some hundreds of metres below. Larger ones had more
ice. What rivers have made of their floors since then is little.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..drainage.climate import ClimateParams, snow_line_m
from .node_arrays import RiverNodes

__all__ = ["glaciated", "with_troughs"]

Floats = NDArray[np.float64]

_LOWERED_M = 1000.0
"""By how much the snow line lay lower."""
_MELTS_M = (1200.0, 700.0)
"""So far below that line tongues of ice ended: none came further down, all came to the second."""
_HEAD_M = (0.0, 400.0)
"""How far above that line valleys begin that had hardly any ice, and those that had all of it."""
_DEEP_M = (200.0, 700.0)
"""The same of how far they have come down: there are no troughs in plains."""
_FLOOR_M, _LEAST_FLOOR_M, _MOST_FLOOR_M = 300.0, 350.0, 1200.0
"""Half of a trough's floor, by the fourth root of the river's discharge in m3/s, and its bounds; of its side, and where
that ends, below."""
_SIDE_M, _SIDE_BY_FLOOR = 1300.0, 0.5


def with_troughs(nodes: RiverNodes, climate: ClimateParams, scale: float, strength: float = 1.0) -> RiverNodes:
    """The nodes with wider floors and steeper sides where there was ice. scale: of valleys on the planet. strength:
    what all discharges are multiplied by."""
    share = glaciated(nodes, climate) * (~nodes.lake)
    water = np.sqrt(np.sqrt(nodes.discharge_m3_s.astype(np.float64) * (1.0 / strength)))
    floor = np.minimum(np.maximum(_FLOOR_M * water, _LEAST_FLOOR_M), _MOST_FLOOR_M) * scale
    floor = np.maximum(floor, nodes.flat_m.astype(np.float64))
    reach = floor * (1.0 + _SIDE_BY_FLOOR) + _SIDE_M * scale
    flat, before = nodes.flat_m.astype(np.float64), nodes.reach_m.astype(np.float64)
    # No valley becomes wider; canyons stay.
    reach = np.minimum(reach, before)
    floor = np.where(reach < before, floor, flat)
    return replace(
        nodes,
        flat_m=(flat + (floor - flat) * share).astype(np.float32),
        reach_m=(before + (reach - before) * share).astype(np.float32),
    )


def glaciated(nodes: RiverNodes, climate: ClimateParams) -> Floats:
    """How much of each valley (N,) ice has made, 0..1."""
    level, head = nodes.level_m.astype(np.float64), _heads(nodes)
    line = snow_line_m(nodes.direction, climate) - _LOWERED_M
    cold = _ramp(level - line, -_MELTS_M[0], -_MELTS_M[1])
    return cold * _ramp(head - line, *_HEAD_M) * _ramp(head - level, *_DEEP_M)


def _heads(nodes: RiverNodes) -> Floats:
    """The highest level (N,) upstream of nodes, or of themselves."""
    found, to = nodes.level_m.astype(np.float64), nodes.to.astype(np.int64)
    many = np.bincount(to[to >= 0], minlength=len(to))
    here = np.flatnonzero((many == 0) & (to >= 0))
    while here.size:
        below = to[here]
        np.maximum.at(found, below, found[here])
        np.subtract.at(many, below, 1)
        below = np.unique(below)
        here = below[(many[below] == 0) & (to[below] >= 0)]
    return found


def _ramp(values: Floats, low: float, high: float) -> Floats:
    t = np.minimum(np.maximum((values - low) / (high - low), 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)
