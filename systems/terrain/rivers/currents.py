"""How fast water flows at places, and where to, in float64.

Lines are straight where a warp has moved the place to (pairs.py), so that is where ways are found: along the lines, and
in lakes straight to where they drain. The inverse of the warp's derivative turns them into ways on the planet. There
water keeps its share of the width, so what crosses that is taken away: it flows along the banks, however uneven.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .pairs import Pairs, bank_gradient, bent_by_place, node_places
from .table import RiverTable

__all__ = ["currents"]

Floats = NDArray[np.float64]

_FASTEST_M_S = 5.0
"""Mean over a section: steep rivers lose what they gain in falls and pools."""
_LEAST_TURN = 1e-6
"""Where the warp flattens ways to less than this nothing tells how it turned them."""


def currents(table: RiverTable, points: Floats, pairs: Pairs) -> Floats:
    """(3, K) m/s, level, at those of the points (3, N) that `pairs` is about; 0 outside the water.

    Mean speed through a parabolic section is discharge over 4/3 of half width times depth, 1.5 of that in its middle,
    none at its edge. Where lines meet, each counts by the depth that it gives the place.
    """
    half, deep = pairs.bank, pairs.value[2]
    discharge = pairs.value[6]
    inside = np.clip(pairs.d / np.maximum(half, 1e-3), 0.0, 1.0)
    left = np.where(half > 0.0, 1.0 - inside * inside, 0.0)
    speed = np.minimum(discharge / np.maximum(4.0 / 3.0 * half * deep, 1e-3), _FASTEST_M_S) * 1.5 * left
    wet = np.flatnonzero(left > 0.0)
    below, flow = np.zeros(len(left)), np.zeros((3, len(left)))
    if not wet.size:
        return np.zeros((3, len(pairs.near)))
    below[wet] = (deep * left)[wet]
    here = points.take(pairs.near, axis=1)
    up = here * (1.0 / table.radius_m)
    bent_m = here + (table.bend_m[:, None] * pairs.bends.vector()).sum(axis=1)
    by_place = np.repeat(np.arange(len(pairs.near)), pairs.many)[wet]
    turned, up_here = bent_by_place(table, pairs).take(by_place, axis=2), up.take(by_place, axis=1)
    ways, free = _ways(table, pairs, wet, bent_m.take(by_place, axis=1), up_here)
    ways = _unbent(turned, up_here, ways)
    # How the share of the width changes, but for a factor.
    by_share = pairs.away.take(wet, axis=1) - inside[wet] * bank_gradient(table, pairs).take(wet, axis=1)
    across = _unit(_level(np.einsum("abw,aw->bw", turned, by_share), up_here))
    ways = _unit(ways - np.where(free, 0.0, (ways * across).sum(axis=0)) * across)
    flow[:, wet] = below[wet] * speed[wet] * ways
    total = np.add.reduceat(below, pairs.first)
    return np.divide(
        np.add.reduceat(flow, pairs.first, axis=1), total, out=np.zeros((3, len(total))), where=total > 0.0
    )


def _ways(
    table: RiverTable, pairs: Pairs, wet: NDArray[np.int64], place: Floats, up: Floats
) -> tuple[Floats, NDArray[np.bool_]]:
    """(3, W) unit, level, where all is bent, for pairs `wet` (W,) at bent places (3, W); and whether banks say nothing
    there (W,): in lakes, and out of the last line straight on."""
    line, lake = pairs.line.take(wet), pairs.value[5].take(wet) > 0.5
    a, b = node_places(table, line), node_places(table, table.to.take(line))
    along = _level(b - a, up)
    length_m = np.sqrt((along * along).sum(axis=0))
    along = along / np.maximum(length_m, 1e-3)
    after = ((place - b) * along).sum(axis=0) > 0.0
    away = pairs.away.take(wet, axis=1)
    # Round the end of a line that goes on, not across the bank.
    to = table.to.take(line)
    goes_on = table.to.take(to) >= 0
    outward = np.where(after & goes_on, np.maximum((along * away).sum(axis=0), 0.0), 0.0)
    way = along - away * outward
    if lake.any():
        target = node_places(table, np.where(after & goes_on, table.to.take(to), to)[lake])
        way[:, lake] = _level(target - place[:, lake], up[:, lake])
    return _unit(way), lake | (after & ~goes_on)


def _unit(ways: Floats) -> Floats:
    return ways / np.maximum(np.sqrt((ways * ways).sum(axis=0)), 1e-9)


def _unbent(turned: Floats, up: Floats, bent: Floats) -> Floats:
    """(3, K) along the ground and as fast, of velocities (3, K) after the warp. turned: its derivative (3, 3, K)."""
    # Two axes along the ground, the first along the bent velocity.
    speed = np.sqrt((bent * bent).sum(axis=0))
    u = bent / np.maximum(speed, 1e-12)
    v = np.cross(up, u, axis=0)
    by_u, by_v = (np.einsum("abk,bk->ak", turned, axis) for axis in (u, v))
    uu, vu = (u * by_u).sum(axis=0), (v * by_u).sum(axis=0)
    uv, vv = (u * by_v).sum(axis=0), (v * by_v).sum(axis=0)
    # Of the inverse of ((uu, uv), (vu, vv)) the first column, as a direction: only its sign needs the determinant.
    fold = uu * vv - uv * vu
    sign = np.where(fold < 0.0, -1.0, 1.0)
    way = sign * (vv * u - vu * v)
    length = np.sqrt((way * way).sum(axis=0))
    return np.where(length > _LEAST_TURN, way / np.maximum(length, _LEAST_TURN), u) * speed


def _level(vectors: Floats, up: Floats) -> Floats:
    return vectors - up * (up * vectors).sum(axis=0)
