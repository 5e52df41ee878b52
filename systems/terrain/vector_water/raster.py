"""Beds and banks of a vector map's water as samples of ground, over all other tiles and the procedural ground.

A lattice of samples STEP_M apart holds what is near shores and rivers, one four times as coarse the beds of wide
water. Where the shore crosses a cell the ground passes the water's level; beyond it stays above it over SHORE samples,
from a bank of 0.4 m up to where it is by itself, and is that from there on (engine/real_ground/pages.py: margins).
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....engine.real_ground.lattice import Lattice, directions_at
from ....engine.real_ground.pages import SLOT, PageLevel, pages_of
from ....engine.real_ground.polygons import Polygons
from ....engine.real_ground.raw_level import BLOCK, RawLevel
from ....engine.real_ground.real_ground import RealGround
from ..rivers.table import CELL_STEPS, RiverTable
from ..rivers.valleys import waters
from .bodies import Body, Ground, along, metres_per_deg

__all__ = ["water_levels"]

log = logging.getLogger(__name__)

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
FACTOR = 4
_STEPS_M = (4.0, 8.0)
_SHORE = 8
"""Samples from the shore to where ground is as it was, and to where the bed is as deep as it gets."""
_WITHIN = 48
"""Fine samples reach so far from shores, at least."""
_INNER = 12
"""Coarse ones begin so many of theirs from it: their own margins end before the shore."""
_BANK_M = 0.4
_ROUND_RIVER = 6.0
"""Samples from a river to where ground is as it was."""
_LEAST_HALF = 0.75
"""Of a river's bed, samples."""
_MOST_BLOCKS = 40_000
"""That are looked at, of either lattice."""
_SLOT_BYTES = 8 * SLOT * SLOT


@dataclass(eq=False)
class _Lines:
    """Of rivers: both ends (E, 2) in degrees and half width, level and depth at both (E, 2)."""

    a: Floats
    b: Floats
    half: Floats
    level: Floats
    depth: Floats


def water_levels(
    bodies: Sequence[Body], table: RiverTable | None, ground: Ground, radius_m: float, most_bytes: int, what: str
) -> list[tuple[PageLevel, int]]:
    """Levels, the finest first, each with how many times finer it is than the next; none where nothing is."""
    lines = _river_lines(table)
    step_m = _STEPS_M[1]
    if len(lines.a):
        step_m = float(np.clip(0.5 * lines.half.min(), *_STEPS_M))
    first_m = step_m
    while True:
        lattice = _lattice(radius_m, step_m)
        fine = _shore_blocks(lattice, bodies, lines, radius_m)
        coarse = None if fine is None else _wide_blocks(lattice.coarser(FACTOR), bodies)
        if fine is not None and coarse is not None and (len(fine) + len(coarse)) * _SLOT_BYTES <= most_bytes:
            break
        step_m *= 1.5
    if step_m > first_m:
        log.warning(
            "%s: shores are known to %.0f m instead of %.0f m, to fit into half of Terrain.height_map_most_mb; raise "
            "it, or give a smaller piece", what, step_m, first_m,
        )  # fmt: skip
    return _levels(bodies, lines, table, ground, radius_m, lattice, fine, coarse)


def _levels(
    bodies: Sequence[Body],
    lines: _Lines,
    table: RiverTable | None,
    ground: Ground,
    radius_m: float,
    lattice: Lattice,
    fine: Ints,
    coarse: Ints,
) -> list[tuple[PageLevel, int]]:
    wide = RawLevel(lattice.coarser(FACTOR))
    for j, i in coarse.tolist():
        bed = _wide_bed(bodies, wide.lattice, j, i)
        if not np.isnan(bed).all():
            wide.blocks[j, i] = bed
    near = RawLevel(lattice)
    for j, i in fine.tolist():
        values = _shore_block(bodies, lines, table, ground, radius_m, lattice, j, i)
        if not np.isnan(values).all():
            near.blocks[j, i] = values
    found = []
    below = pages_of(wide, ground, False) if wide.blocks else None

    def around(latitude_deg: Floats, longitude_deg: Floats) -> Floats:
        heights = ground(latitude_deg, longitude_deg)
        if below is None:
            return heights
        bed, rest = RealGround((below,), (0,), (0,), 0.0, 0.0).heights(directions_at(latitude_deg, longitude_deg))
        return bed + rest * heights

    if near.blocks:
        level = pages_of(near, around, True)
        if level is not None:
            found.append((level, FACTOR))
    if below is not None:
        found.append((below, FACTOR))
    return found


def _lattice(radius_m: float, step_m: float) -> Lattice:
    """Whole blocks around the world, of both lattices."""
    unit = BLOCK * FACTOR
    across = max(unit * round(2.0 * np.pi * radius_m / (step_m * unit)), unit)
    return Lattice(False, float(across), float(across // 2), 0.5, 0.5)


def _river_lines(table: RiverTable | None) -> _Lines:
    if table is None:
        return _Lines(*(np.zeros((0, 2)) for _ in range(5)))
    node = np.flatnonzero((table.to >= 0) & (table.values[:, 5] < 0.5))
    to = table.to[node]
    places = table.place * (table.cell_m / CELL_STEPS)

    def degrees(at: NDArray[np.integer]) -> Floats:
        x, y, z = places[at].T
        return np.degrees(np.stack([np.arctan2(y, x), np.arctan2(z, np.hypot(x, y))], axis=1))

    a, b = degrees(node), degrees(to)
    b[:, 0] -= 360.0 * np.rint((b[:, 0] - a[:, 0]) / 360.0)
    half, level, depth = (np.stack([table.values[node, k], table.values[to, k]], axis=1) for k in (1, 0, 2))
    return _Lines(a, b, *(v.astype(np.float64) for v in (half, level, depth)))


# -- which blocks -----------------------------------------------------------------------------------------------------


def _shore_blocks(lattice: Lattice, bodies: Sequence[Body], lines: _Lines, radius_m: float) -> Ints | None:
    """(K, 2) rows and columns of blocks near shores and rivers; None: too many."""
    found = [np.zeros((0, 2), np.int64)]
    step_m = lattice.sample_m(radius_m)
    asked = [(body.area.edges, float(_WITHIN)) for body in bodies]
    if len(lines.a):
        reach = float(lines.half.max()) / step_m + _ROUND_RIVER + 2.0
        asked.append((np.concatenate([lines.a, lines.b], axis=1), reach))
    for edges, reach in asked:
        apart_deg = 0.5 * BLOCK * lattice.step_deg
        if np.hypot(*(edges[:, 2:] - edges[:, :2]).T).sum() / apart_deg > 50.0 * _MOST_BLOCKS:
            return None
        points = along(edges, apart_deg, 60 * _MOST_BLOCKS + len(edges))
        flat = np.maximum(np.cos(np.radians(points[:, 1])), 1e-3)
        for dx in (-1.0, 0.0, 1.0):
            for dy in (-1.0, 0.0, 1.0):
                column, row = _samples(lattice, points[:, 0], points[:, 1])
                at = np.stack([(row + dy * reach) // BLOCK, (column + dx * reach / flat) // BLOCK], axis=1)
                found.append(np.unique(at.astype(np.int64), axis=0))
                if sum(map(len, found)) > 9 * _MOST_BLOCKS:
                    return None
    return _wrapped(lattice, np.concatenate(found))


def _wide_blocks(lattice: Lattice, bodies: Sequence[Body]) -> Ints | None:
    """(K, 2) blocks of the coarse lattice in which wide water may lie; None: too many."""
    found = [np.zeros((0, 2), np.int64)]
    for body in bodies:
        if body.band:
            continue
        west, south, east, north = body.area.bounds
        (left, right), (top, bottom) = _samples(lattice, np.array([west, east]), np.array([north, south]))
        if min(right - left, bottom - top) < 2 * _INNER:
            continue
        rows = np.arange(int(top // BLOCK), int(bottom // BLOCK) + 1)
        columns = np.arange(int(left // BLOCK), int(right // BLOCK) + 1)
        if len(rows) * len(columns) + sum(map(len, found)) > _MOST_BLOCKS:
            return None
        j, i = (v.ravel() for v in np.meshgrid(rows, columns, indexing="ij"))
        latitude = np.asarray(90.0 - (j + 0.5) * BLOCK * 180.0 / lattice.down, dtype=np.float64)
        longitude = np.asarray((i + 0.5) * BLOCK * 360.0 / lattice.across - 180.0, dtype=np.float64)
        near = body.area.inside(longitude, latitude)
        points = along(body.area.edges, 0.5 * BLOCK * lattice.step_deg, 60 * _MOST_BLOCKS + len(body.area.edges))
        column, row = _samples(lattice, *points.T)
        touched = np.unique(np.stack([row // BLOCK, column // BLOCK], axis=1).astype(np.int64), axis=0)
        found += [np.stack([j[near], i[near]], axis=1), touched]
    return _wrapped(lattice, np.concatenate(found))


def _wrapped(lattice: Lattice, blocks: Ints) -> Ints:
    rows, columns = round(lattice.down) // BLOCK, lattice.period // BLOCK
    blocks = blocks[(blocks[:, 0] >= 0) & (blocks[:, 0] < rows)]
    blocks[:, 1] %= columns
    return np.unique(blocks, axis=0)


def _samples(lattice: Lattice, longitude_deg: Floats, latitude_deg: Floats) -> tuple[Floats, Floats]:
    return lattice.index(*lattice.world(latitude_deg, longitude_deg))


# -- what they hold ---------------------------------------------------------------------------------------------------


def _share(area: Polygons, lattice: Lattice, row: int, column: int, side: int) -> Floats | None:
    """(side, side) of samples from (row, column) on; None where no polygon is near."""
    west, east = ((c + lattice.phase_x - 0.5) * 360.0 / lattice.across - 180.0 for c in (column, column + side))
    north, south = (90.0 - (r + lattice.phase_y - 0.5) * 180.0 / lattice.down for r in (row, row + side))
    if area.bounds[1] > north or area.bounds[3] < south:
        return None
    found = None
    for turn in area.turns_deg(west, east):
        x, y = _samples(lattice, area.edges[:, 0::2] - turn, area.edges[:, 1::2])
        part = area.shares(x - column, y - row, side, side)
        found = part if found is None else np.minimum(found + part, 1.0)
    return found


def _blurred(share: Floats, by: int) -> Floats:
    """Means over squares of 2 by + 1, of which by rows and columns at each edge are left out."""
    for axis in (0, 1):
        total = np.cumsum(np.pad(share, [(1, 0) if k == axis else (0, 0) for k in (0, 1)]), axis)
        size = share.shape[axis] - 2 * by
        share = np.take(total, np.arange(2 * by + 1, 2 * by + 1 + size), axis) - np.take(total, np.arange(size), axis)
        share = share / (2 * by + 1)
    return share


def _wide_bed(bodies: Sequence[Body], lattice: Lattice, j: int, i: int) -> NDArray[np.float32]:
    """A coarse block: beds of wide water."""
    found = np.full((BLOCK, BLOCK), np.nan, np.float32)
    for body in bodies:
        if body.band:
            continue
        share = _share_of(body, lattice, j * BLOCK - _INNER, i * BLOCK - _INNER, BLOCK + 2 * _INNER)
        if share is None:
            continue
        deep = _blurred(share, _INNER) > 1.0 - 1e-9
        found[deep] = np.fmin(found[deep], np.float32(body.level_m - body.depth_m))
    return found


def _share_of(body: Body, lattice: Lattice, row: int, column: int, side: int) -> Floats | None:
    share = _share(body.area, lattice, row, column, side)
    if share is None:
        return None
    if body.band:
        return 1.0 - share
    land = None if body.land is None else _share(body.land, lattice, row, column, side)
    return share if land is None else share * (1.0 - land)


def _shore_block(
    bodies: Sequence[Body],
    lines: _Lines,
    table: RiverTable | None,
    ground: Ground,
    radius_m: float,
    lattice: Lattice,
    j: int,
    i: int,
) -> NDArray[np.float32]:
    """A fine block: beds of water, and the ground around it."""
    shape = BLOCK, BLOCK
    bed, floor, beyond = np.full(shape, np.inf), np.full(shape, -np.inf), np.full(shape, np.inf)
    for body in bodies:
        margin = _SHORE
        share = _share_of(body, lattice, j * BLOCK - margin, i * BLOCK - margin, BLOCK + 2 * margin)
        if share is None:
            continue
        inner = 2.0 * _blurred(share, margin) - 1.0
        here = share[margin:-margin, margin:-margin]
        wet, near = here >= 0.5, (inner > -1.0) | (here > 0.0)
        if body.band:
            wet, near = wet & (inner < 1.0), near & (inner < 1.0)
        t = np.clip(inner, 0.0, 1.0)
        sunk = body.level_m - _BANK_M * (2.0 * here - 1.0) - (body.depth_m - _BANK_M) * t * t * (3.0 - 2.0 * t)
        bed[wet] = np.minimum(bed[wet], sunk[wet])
        dry = near & ~wet
        floor[dry] = np.maximum(floor[dry], (body.level_m + _BANK_M * (1.0 - 2.0 * here))[dry])
        beyond[dry] = np.minimum(beyond[dry], np.clip(-inner, 0.0, 1.0)[dry])
    stream = np.full(shape, np.inf)
    _rivers(lines, lattice, radius_m, j, i, stream, floor, beyond)
    if table is not None and np.isfinite(bed).any():
        _below_mouths(table, lattice, j, i, stream, np.isfinite(stream) & ~np.isfinite(bed))
    bed = np.minimum(bed, stream)
    values = np.where(np.isfinite(bed), bed, np.nan)
    asked = np.isnan(values) & np.isfinite(beyond)
    rows, columns = np.nonzero(asked)
    if len(rows):
        latitude, longitude = lattice.place(columns + i * BLOCK, rows + j * BLOCK)
        own, low, t = ground(latitude, longitude), floor[asked], beyond[asked]
        values[asked] = low + t * t * (3.0 - 2.0 * t) * (np.maximum(own, low) - low)
    return values.astype(np.float32)


def _below_mouths(
    table: RiverTable, lattice: Lattice, j: int, i: int, stream: Floats, asked: NDArray[np.bool_]
) -> None:
    """Beds of rivers where a lake's lines pull their level down: below that as well."""
    rows, columns = np.nonzero(asked)
    latitude, longitude = lattice.place(columns + i * BLOCK, rows + j * BLOCK)
    found = waters(table, directions_at(latitude, longitude) * table.radius_m)
    low = np.where(found.beyond_m < 0.0, found.level_m - _BANK_M, np.inf)
    stream[asked] = np.minimum(stream[asked], low)


def _rivers(
    lines: _Lines, lattice: Lattice, radius_m: float, j: int, i: int, bed: Floats, floor: Floats, beyond: Floats
) -> None:
    """What rivers make of bed, floor and beyond (rows, columns) of a block."""
    if not len(lines.a):
        return
    latitude, longitude = lattice.place((i + 0.5) * BLOCK, (j + 0.5) * BLOCK)
    x, y = metres_per_deg(radius_m, float(latitude))
    step_m = lattice.sample_m(radius_m)
    turn = 360.0 * np.rint((lines.a[:, 0] - float(longitude)) / 360.0)
    middle = np.array([float(longitude), float(latitude)])
    a = (lines.a - np.stack([turn, np.zeros_like(turn)], axis=1) - middle) * (x, y)
    b = (lines.b - np.stack([turn, np.zeros_like(turn)], axis=1) - middle) * (x, y)
    wide = np.maximum(lines.half, _LEAST_HALF * step_m)
    reach = wide.max(axis=1) + (_ROUND_RIVER + 1.0) * step_m
    size = np.array([360.0 * x / lattice.across, 180.0 * y / lattice.down])
    half_block = 0.5 * BLOCK * size
    low, high = np.minimum(a, b) - reach[:, None], np.maximum(a, b) + reach[:, None]
    for k in np.flatnonzero((low < half_block).all(axis=1) & (high > -half_block).all(axis=1)):
        # Rows go south.
        c0, c1 = (int(np.clip(np.floor(v[k, 0] / size[0] + 0.5 * BLOCK), 0, BLOCK)) for v in (low, high))
        r0, r1 = (int(np.clip(np.floor(0.5 * BLOCK - v[k, 1] / size[1]), 0, BLOCK)) for v in (high, low))
        cut = slice(r0, r1 + 1), slice(c0, c1 + 1)
        px = (np.arange(BLOCK)[cut[1]] + 0.5 - 0.5 * BLOCK) * size[0] - a[k, 0]
        py = (0.5 * BLOCK - 0.5 - np.arange(BLOCK)[cut[0]])[:, None] * size[1] - a[k, 1]
        way = b[k] - a[k]
        t = np.clip((px * way[0] + py * way[1]) / max(float(way @ way), 1e-9), 0.0, 1.0)
        d = np.hypot(px - t * way[0], py - t * way[1])
        half, level, depth = (v[k, 0] + t * (v[k, 1] - v[k, 0]) for v in (wide, lines.level, lines.depth))
        off = (d - half) / step_m
        q = np.minimum(d / half, 1.0)
        wet = off < 0.0
        bed[cut][wet] = np.minimum(bed[cut][wet], (level - 0.05 - depth * (1.0 - q * q))[wet])
        dry = ~wet & (off < _ROUND_RIVER)
        floor[cut][dry] = np.maximum(floor[cut][dry], (level + _BANK_M * np.clip(off, 0.0, 1.0))[dry])
        beyond[cut][dry] = np.minimum(beyond[cut][dry], np.clip(off / _ROUND_RIVER, 0.0, 1.0)[dry])
