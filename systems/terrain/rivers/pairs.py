"""Which lines of rivers places are held against, float64.

A place is moved by the warp that bends lines, and held against the straight lines of its cell. Distances count along
the ground: what points up or down is taken away.

Most lines of a cell are too far away to say anything. The place itself tells, since the warp moves it by so much at
most; the others are left out before it is moved.

Near water banks are uneven (banks.py); levels know straight ones alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....engine.surface.noise import Corners
from .banks import uneven
from .form import HELD, bank_slopes
from .table import CELL_STEPS, RiverTable, cell_keys

__all__ = ["Pairs", "bank_gradient", "bent_by_place", "chosen", "node_places", "river_pairs"]

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Nodes = NDArray[np.int32]


@dataclass(frozen=True)
class Pairs:
    """Places and lines that are held against each other, P in all, sorted by place."""

    where: Indices
    """(P,) indices of places"""
    first: Indices
    """(K,) where each of the places that have any begins"""
    near: Indices
    """(K,) those places"""
    many: Indices
    """(K,) how many lines each of them has"""
    line: Nodes
    """(P,) nodes upstream"""
    value: Floats
    """(8, P) of the river there"""
    steps: Floats
    """(8, P) of these along the whole line"""
    bank: Floats
    """(P,) half width between uneven banks, m"""
    moved: Indices
    """(Q,) which of the pairs have such"""
    noise: Corners
    """of the noise that makes them so, (3, 3, Q)"""
    d: Floats
    """(P,) m"""
    away: Floats
    """(3, P) unit, from the line to the place, level"""
    along: Floats
    """(3, P) change of the line's parameter by place, 1/m; 0 beyond its ends"""
    length_m: Floats
    """(P,) of the lines"""
    end_m: Floats
    """(P,) along the line to its nearest end"""
    bends: Corners
    """of the warp around the places that have any, (3, 2, K)"""


def chosen(values: Floats, wanted: Floats, pairs: Pairs) -> Indices:
    """(K,) index of the pair that has each place's `wanted` value."""
    same = values == np.repeat(wanted, pairs.many)
    number = np.where(same, np.arange(len(values)), len(values))
    return np.minimum.reduceat(number, pairs.first)


def bent_by_place(table: RiverTable, pairs: Pairs) -> Floats:
    """(3, 3, K): how the bent place changes [a] with the place [b]."""
    _, jacobian = pairs.bends.vector_derivative()
    turned = (jacobian * (table.bends.frequency * table.bend_m)[:, None]).sum(axis=2)
    for axis in range(3):
        turned[axis, axis] += 1.0
    return turned


def bank_gradient(table: RiverTable, pairs: Pairs) -> Floats:
    """(3, P) how half widths between banks change with the bent place."""
    found, near = pairs.steps[1] * pairs.along, pairs.moved
    if near.size:
        noise, slope = pairs.noise.vector_derivative()
        made = bank_slopes(pairs.d[near], pairs.value[1, near], pairs.value[3, near], table.uneven, *noise[0])
        by_line = made[2] * pairs.steps[1, near] + made[3] * pairs.steps[3, near]
        changed = made[1] * pairs.away[:, near] + by_line * pairs.along[:, near]
        for octave, frequency in enumerate(table.banks.frequency):
            changed += made[5 + octave] * frequency * slope[0, :, octave]
        found[:, near] = changed
    return found


def river_pairs(table: RiverTable, points: Floats, in_reach: bool = True, more_m: float = 0.0) -> Pairs | None:
    """Of points (3, N) on the reference sphere, m; None without any. in_reach: only lines that say something there, or
    up to more_m beyond, otherwise all lines of the points' cells."""
    near, cells = table.cells_at(cell_keys(np.floor(points * (1.0 / table.cell_m)).astype(np.int64)))
    if not near.size:
        return None
    begin = table.begin.take(cells).astype(np.int64)
    many = table.begin.take(cells + 1) - begin
    line = table.lines.take(np.repeat(begin - (np.cumsum(many) - many), many) + np.arange(int(many.sum())))
    where = np.repeat(near, many)
    if in_reach:
        within = _within(table, points, where, line, more_m)
        where, line = where[within], line[within]
        if not where.size:
            return None
    first, near, many = _groups(where)

    here = points.take(near, axis=1)
    bends = table.bends.cells(here)
    bent = here + (table.bend_m[:, None] * bends.vector()).sum(axis=1)
    up, bent = (np.repeat(v, many, axis=1) for v in (here * (1.0 / table.radius_m), bent))
    to = table.to.take(line)
    a, b = node_places(table, line), node_places(table, to)
    way, from_a = b - a, bent - a
    way = way - up * (up * way).sum(axis=0)
    from_a = from_a - up * (up * from_a).sum(axis=0)
    square = np.maximum((way * way).sum(axis=0), 1e-6)
    t = (from_a * way).sum(axis=0) / square
    inside, length_m = (t > 0.0) & (t < 1.0), np.sqrt(square)
    end_m = np.minimum(np.abs(t), np.abs(1.0 - t)) * length_m
    t = np.clip(t, 0.0, 1.0)
    off = from_a - t * way
    d = np.sqrt((off * off).sum(axis=0))
    upstream, downstream = (table.values.take(n, axis=0).T.astype(np.float64, order="C") for n in (line, to))
    steps = downstream - upstream
    # Of a lake are lines between two of its nodes.
    steps[5], upstream[5] = 0.0, upstream[5] * downstream[5]
    value = upstream + t * steps
    along, away = np.where(inside, way / square, 0.0), off / np.maximum(d, 1e-9)
    floor, reach = value[3:5]
    kept = np.flatnonzero(d < np.maximum(reach, floor + HELD * reach) + more_m) if in_reach else np.arange(len(d))
    if not kept.size:
        return None
    if len(kept) < len(d):
        # By take: what is indexed along its last axis has that as its slowest in memory.
        value, steps, d, away, along, bent, length_m, end_m = (
            rows.take(kept, axis=-1) for rows in (value, steps, d, away, along, bent, length_m, end_m)
        )
        line = line.take(kept)
        where, before = where[kept], near
        first, near, many = _groups(where)
        bends = bends.at(np.searchsorted(before, near))
    bank, moved, noise = uneven(table.banks, table.uneven, bent, d, value)
    return Pairs(
        where, first, near, many, line, value, steps, bank, moved, noise, d, away, along, length_m, end_m, bends
    )


def node_places(table: RiverTable, nodes: Nodes) -> Floats:
    """(3, P) m"""
    return np.multiply(table.place.take(nodes, axis=0).T, table.cell_m / CELL_STEPS, order="C")


def _groups(where: Indices) -> tuple[Indices, Indices, Indices]:
    """Of rising numbers (P,): where new ones begin, these, and how often each is there (K,)."""
    first = np.append(0, np.flatnonzero(where[1:] != where[:-1]) + 1)
    many = np.empty_like(first)
    np.subtract(first[1:], first[:-1], out=many[:-1])
    many[-1] = len(where) - first[-1]
    return first, where.take(first), many


def _within(table: RiverTable, points: Floats, where: Indices, line: Nodes, more_m: float) -> Indices:
    """Indices of pairs (P,) whose lines may say something at the place, wherever the warp moves it."""
    place = points.take(where, axis=1)
    a = node_places(table, line)
    way, off = node_places(table, table.to.take(line)) - a, place - a
    up = place * (1.0 / table.radius_m)
    rise, above = np.einsum("ap,ap->p", way, up), np.einsum("ap,ap->p", off, up)
    square = np.einsum("ap,ap->p", way, way) - rise * rise
    both = np.einsum("ap,ap->p", off, way) - above * rise
    t = np.clip(both / np.maximum(square, 1e-6), 0.0, 1.0)
    away = np.einsum("ap,ap->p", off, off) - above * above - t * (2.0 * both - t * square)
    bent_m = float(table.bend_m.sum()) * np.sqrt(3.0)
    far = _ROUNDED * (table.far_m.take(line) + (bent_m + more_m))
    return np.flatnonzero(away <= far * far)


_ROUNDED = 1.001
"""More than squares of distances between a place and its cell's lines are rounded."""
