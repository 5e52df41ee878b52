"""Waterfalls: where a river comes down steeply some of that is a fall, and its bed above and below is flatter.

Hard rock lies in steps; a river wears it away most where it falls over one (knickpoints). Between two nodes levels are
linear, so a fall is a short line between two nodes more.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ....engine.surface.noise import pcg3d
from .node_arrays import RiverNodes

__all__ = ["HIGHEST_M", "LEAST_M", "STEEPNESS", "with_falls"]

Floats = NDArray[np.float64]

STEEPNESS = 2.0
"""Of falls: height by length."""
_LEAST_DROP_M, _LEAST_SLOPE = 60.0, 0.008
"""Of lines that may have a fall: how far they come down, and how steeply."""
_SHARE, HIGHEST_M = 0.45, 70.0
"""Of that a fall is so much at most, and no higher."""
_LOWEST = 0.4
"""And at least so much of these."""
_ONE_OF = 2
"""Of so many of those one has a fall."""
_LEAST_M3_S = 2.0
LEAST_M = 0.99 * _LOWEST * _SHARE * _LEAST_DROP_M
"""No fall is lower."""


def with_falls(nodes: RiverNodes, radius_m: float, strength: float = 1.0) -> RiverNodes:
    """The nodes with those of falls, which come last: all lips, then all feet.

    strength: what all discharges are multiplied by; where falls are does not depend on it.
    """
    to, level = nodes.to.astype(np.int64), nodes.level_m.astype(np.float64)
    line = np.flatnonzero((to >= 0) & ~nodes.lake & ~nodes.lake[to])
    below = to[line]
    x, y, z = (nodes.direction[below] - nodes.direction[line]).T
    length_m = np.sqrt(x * x + y * y + z * z) * radius_m
    drop_m = level[line] - level[below]
    word = pcg3d(line.astype(np.uint32), np.full(len(line), 17, np.uint32), np.zeros(len(line), np.uint32))
    chosen = (drop_m >= _LEAST_DROP_M) & (drop_m >= _LEAST_SLOPE * length_m)
    chosen &= (word[0] >> np.uint32(16)) % _ONE_OF == 0
    # A little less, so that rounding changes nothing.
    chosen &= nodes.discharge_m3_s[line].astype(np.float64) >= 0.999 * _LEAST_M3_S * strength
    line, below = line[chosen], below[chosen]
    length_m, drop_m = length_m[chosen], drop_m[chosen]
    uneven = (word[2][chosen] >> np.uint32(8)).astype(np.float64) * 2.0**-24
    fall_m = np.minimum(_SHARE * drop_m, HIGHEST_M) * (_LOWEST + (1.0 - _LOWEST) * uneven)
    # In the middle half.
    lip = 0.25 + (word[1][chosen] >> np.uint32(8)).astype(np.float64) * 2.0**-25
    foot = lip + fall_m / (STEEPNESS * length_m)
    count, many = len(to), len(line)
    to[line] = count + np.arange(many)
    gone_m = (drop_m - fall_m) * lip
    levels = [level[line] - gone_m, level[line] - gone_m - fall_m]
    share = np.concatenate([lip, foot])

    def between(values: NDArray[np.floating]) -> Floats:
        a, b = (np.concatenate([values[n], values[n]]).astype(np.float64) for n in (line, below))
        return a + (b - a) * (share if a.ndim == 1 else share[:, None])

    x, y, z = between(nodes.direction).T
    direction = np.stack([x, y, z], axis=1) / np.sqrt(x * x + y * y + z * z)[:, None]
    names = ("half_width_m", "depth_m", "flat_m", "reach_m", "discharge_m3_s")
    rows = {n: np.concatenate([getattr(nodes, n), between(getattr(nodes, n)).astype(np.float32)]) for n in names}
    return replace(
        nodes,
        direction=np.concatenate([nodes.direction, direction]),
        to=np.concatenate([to, count + many + np.arange(many), below]).astype(np.int32),
        level_m=np.concatenate([nodes.level_m, np.concatenate(levels).astype(np.float32)]),
        lake=np.concatenate([nodes.lake, np.zeros(2 * many, bool)]),
        **rows,
    )
