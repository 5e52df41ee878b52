"""What rivers make of the ground at places, in float64: the twin of assets/shaders/terrain/rivers.glsl.

A place is held against the lines about it (pairs.py), and each says what it makes of the ground there (form.py).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..height_steps import layer_weight
from .currents import currents
from .form import (
    open_slopes,
    raise_slopes,
    river_open,
    river_raise,
    river_section,
    river_share,
    section_slopes,
    share_slopes,
)
from .pairs import Pairs, bank_gradient, bent_by_place, chosen, river_pairs
from .table import BESIDE_M, RiverTable

__all__ = ["Valleys", "Waters", "beside_water", "from_water_m", "shown_slopes", "valleys", "waters"]

Floats = NDArray[np.float64]
Slopes = Literal["none", "open", "all"]


@dataclass(frozen=True)
class Valleys:
    """At N places. Gradients (3, N) are by the place, not tangential; None where they were not asked for."""

    base_m: Floats
    """(N,) the ground of the river there: bed, bank or floor; 0 where no valley reaches"""
    open: Floats
    """(N,) share of the ground's height above it that is left"""
    raised: Floats
    """(N,) share of the ground's depth below it that is filled"""
    reach_m: Floats
    """(N,) of the valley, to one side; 0 where there is none, or no gradient was asked for"""
    d_base: Floats | None = None
    d_open: Floats | None = None
    d_raised: Floats | None = None
    pairs: Pairs | None = None
    """what was held against what; None where no line is near"""


@dataclass(frozen=True)
class Waters:
    """At N places."""

    level_m: Floats
    """(N,) of the nearest water, by all lines around"""
    beyond_m: Floats
    """(N,) distance from its edge, negative in the water; infinite where there is none"""
    depth_m: Floats
    """(N,) of the bed below the level, 0 where dry"""
    current_m_s: Floats
    """(3, N)"""


def shown_slopes(cut: Valleys, footprint_m: Floats | None) -> tuple[Floats, Floats, Floats]:
    """Gradients of base, open and raised (3, N) as a footprint (N,) shows them: a valley is a wave as wide as both of
    its sides."""
    assert cut.d_base is not None and cut.d_open is not None and cut.d_raised is not None
    if footprint_m is None:
        return cut.d_base, cut.d_open, cut.d_raised
    shown = layer_weight(2.0 * cut.reach_m, np.maximum(footprint_m, 1e-9))
    return shown * cut.d_base, shown * cut.d_open, shown * cut.d_raised


def valleys(table: RiverTable, points: Floats, slopes: Slopes = "none") -> Valleys:
    """At points (3, N), planet-centred metres on the reference sphere. slopes: the gradients that are asked for."""
    count = points.shape[1]
    base, left, raised = np.zeros(count), np.ones(count), np.zeros(count)
    d_open = None if slopes == "none" else np.zeros((3, count))
    d_base, d_raised = (np.zeros((3, count)) if slopes == "all" else None for _ in range(2))
    reach_m = np.zeros(count)
    pairs = river_pairs(table, points)
    found = Valleys(base, left, raised, reach_m, d_base, d_open, d_raised, pairs)
    if pairs is None:
        return found
    level, half, depth, floor, reach, lake = pairs.value[:6]
    at, first, d = pairs.near, pairs.first, pairs.d
    share, section = river_share(d, half, reach), river_section(d, pairs.bank, depth)
    opens, raises = river_open(d, floor, reach), river_raise(d, pairs.bank, floor, reach, lake)
    total = np.add.reduceat(share, first)
    # Relative to one of them: levels of kilometres and shares that add up to one lose no millimetres.
    mean = level[first]
    own = level + section - np.repeat(mean, pairs.many)
    heard = total > 0.0
    off = np.divide(np.add.reduceat(share * own, first), total, out=np.zeros(len(at)), where=heard)
    base[at] = np.where(heard, mean + off, 0.0)
    left[at], raised[at] = np.minimum.reduceat(opens, first), np.maximum.reduceat(raises, first)
    if d_open is None:
        return found
    turned = bent_by_place(table, pairs)
    k = chosen(opens, left[at], pairs)
    d_open[:, at] = np.einsum("abn,an->bn", turned, _d_open(pairs, k))
    reach_m[at] = np.where(left[at] < 1.0, reach[k], 0.0)
    if d_base is not None and d_raised is not None:
        apart = own - np.repeat(off, pairs.many)
        by_bank = bank_gradient(table, pairs)
        d_base[:, at] = np.einsum("abn,an->bn", turned, _d_base(pairs, by_bank, share, apart, total))
        d_raised[:, at] = np.einsum("abn,an->bn", turned, _d_raised(pairs, by_bank, chosen(raises, raised[at], pairs)))
    return found


def _d_base(pairs: Pairs, by_bank: Floats, share: Floats, apart: Floats, total: Floats) -> Floats:
    """(3, K) by the bent place. by_bank (3, P): how banks change; apart: of what each line says from the mean."""
    _, half, depth, _, reach = pairs.value[:5]
    s_level, s_half, s_depth, _, s_reach = pairs.steps[:5]
    d, away, along = pairs.d, pairs.away, pairs.along
    sections, shares = section_slopes(d, pairs.bank, depth), share_slopes(d, half, reach)
    d_own = sections[1] * away + sections[2] * by_bank + (s_level + sections[3] * s_depth) * along
    d_share = shares[1] * away + (shares[2] * s_half + shares[3] * s_reach) * along
    d_base = np.add.reduceat(share * d_own + apart * d_share, pairs.first, axis=1)
    return np.divide(d_base, total, out=np.zeros_like(d_base), where=total > 0.0)


def _d_open(pairs: Pairs, k: NDArray[np.int64]) -> Floats:
    """(3, K) by the bent place, of the pairs that say it."""
    floor, reach = pairs.value[3:5, k]
    s_floor, s_reach = pairs.steps[3:5, k]
    opens = open_slopes(pairs.d[k], floor, reach)
    return opens[1] * pairs.away[:, k] + (opens[2] * s_floor + opens[3] * s_reach) * pairs.along[:, k]


def _d_raised(pairs: Pairs, by_bank: Floats, m: NDArray[np.int64]) -> Floats:
    """(3, K) by the bent place, of the pairs that say it. by_bank (3, P): how banks change."""
    floor, reach, lake = pairs.value[3:6, m]
    s_floor, s_reach = pairs.steps[3:5, m]
    raises = raise_slopes(pairs.d[m], pairs.bank[m], floor, reach, lake)
    by_line = raises[3] * s_floor + raises[4] * s_reach
    return raises[1] * pairs.away[:, m] + raises[2] * by_bank[:, m] + by_line * pairs.along[:, m]


def beside_water(table: RiverTable, points: Floats) -> Floats:
    """(N,) 1 in rivers and lakes .. 0 from 100 m from their edges on, or where their valleys end. Rivers of a map have
    none; its lakes count for nothing, since their lines reach over dry ground."""
    found = np.zeros(points.shape[1])
    pairs = river_pairs(table, points, more_m=BESIDE_M * table.given)
    if pairs is not None:
        wide = BESIDE_M if table.given else np.minimum(BESIDE_M, np.maximum(pairs.value[4] - pairs.bank, 1e-3))
        near = np.clip(1.0 - _from_edges(table, pairs) / wide, 0.0, 1.0)
        found[pairs.near] = np.maximum.reduceat(near, pairs.first)
    return found


def from_water_m(table: RiverTable, points: Floats) -> Floats:
    """(N,) how far from the edge of the nearest river or lake they are, m, as lines are measured; negative in it,
    infinite beyond its valley. Lakes of a map count for nothing, as in `beside_water`."""
    found = np.full(points.shape[1], np.inf)
    pairs = river_pairs(table, points, more_m=BESIDE_M * table.given)
    if pairs is not None:
        found[pairs.near] = np.minimum.reduceat(_from_edges(table, pairs), pairs.first)
    return found


def _from_edges(table: RiverTable, pairs: Pairs) -> Floats:
    """(P,) metres from the water of each pair's line, infinite without any."""
    wets = (pairs.bank > 0.0) & ~((pairs.value[5] > 0.5) & table.given)
    return np.where(wets, pairs.d - pairs.bank, np.inf)


def waters(table: RiverTable, points: Floats) -> Waters:
    """Of rivers and lakes at points (3, N), planet-centred metres on the reference sphere."""
    count = points.shape[1]
    level, beyond = np.zeros(count), np.full(count, np.inf)
    depth, current = np.zeros(count), np.zeros((3, count))
    pairs = river_pairs(table, points, table.given)
    if pairs is None:
        return Waters(level, beyond, depth, current)
    height, half, deep, _, reach = pairs.value[:5]
    share = river_share(pairs.d, half, reach) * (half > 0.0)
    total = np.add.reduceat(share, pairs.first)
    at, heard = pairs.near, total > 0.0
    mean = height[pairs.first]

    def heard_of(values: Floats) -> Floats:
        return np.divide(np.add.reduceat(share * values, pairs.first), total, out=np.zeros(len(at)), where=heard)

    level[at] = np.where(heard, mean + heard_of(height - np.repeat(mean, pairs.many)), 0.0)
    depth[at] = np.maximum(-heard_of(river_section(pairs.d, pairs.bank, deep)), 0.0)
    edge = np.where(half > 0.0, pairs.d - pairs.bank, np.inf)
    beyond[at] = np.minimum.reduceat(edge, pairs.first)
    current[:, at] = currents(table, points, pairs)
    return Waters(level, beyond, depth, current)
