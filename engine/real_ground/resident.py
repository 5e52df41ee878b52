"""From tiles to levels of pages that fit into memory: each set at the finest resolution that it can have there."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import NDArray

from .kept_ground import Keeper
from .lattice import directions_at
from .pages import SLOT, PageLevel, pages_of
from .raw_level import BLOCK, RawLevel, factor_of
from .real_ground import RealGround, World, sample_level
from .tile_files import TileError, read_tile
from .tile_index import TileSet, open_tiles, tiles_stamp
from .water_mask import water_of

__all__ = ["MOST_LEVELS", "make_ground", "real_ground", "resident_ground"]

log = logging.getLogger(__name__)

Progress = Callable[[int, int], None]
MOST_LEVELS = 24
"""Of all sets together: the GPU has room for so many."""
_WIDEST_STEP_DEG = 0.14
"""Levels end at samples so far apart: the margin of the last one is 1000 km wide on Earth."""
_SLOT_BYTES = 4 * SLOT * SLOT
_reading = Lock()
_in_use: WeakValueDictionary[tuple[int, tuple[object, ...]], RealGround] = WeakValueDictionary()
"""All that somebody still holds, however many planets have tiles, and the last one that was asked for."""
_last: list[RealGround] = []


def real_ground(path: str, most_bytes: int, what: str) -> RealGround:
    """The map at `path`, read once as long as its files stay as they are, in at most about so many bytes. TileError
    says what is wrong."""
    stamp = tiles_stamp(path)
    with _reading:
        found = _in_use.get((most_bytes, stamp))
        if found is None:
            found = Keeper(stamp, most_bytes).load() or resident_ground(open_tiles(path, what), most_bytes, what)
            _in_use[most_bytes, stamp] = found
        _last[:] = [found]
    return found


def make_ground(path: str, most_bytes: int, what: str, progress: Progress | None = None) -> tuple[RealGround, Path]:
    """Read the map at `path` and keep its levels, so that scenes start at once; and the file they are in. What was cut
    off goes on where it was. TileError says what is wrong."""
    keeper = Keeper(tiles_stamp(path), most_bytes)
    file = keeper.file
    if file is None:
        raise TileError(f"{what}: there is no cache folder (PLANETFALL_CACHE is empty); unset it, or name a folder")
    found = keeper.load()
    if found is None:
        found = resident_ground(open_tiles(path, what, progress), most_bytes, what, progress, keeper)
        if keeper.save(found) is None:
            raise TileError(f"{what}: {file} can't be written; make room, or set PLANETFALL_CACHE to another folder")
    return found, file


@dataclass(frozen=True)
class _Plan:
    """A set, and how many samples of its files make one of its finest level."""

    tiles: TileSet
    factor: int


def resident_ground(
    sets: Sequence[TileSet], most_bytes: int, what: str, progress: Progress | None = None, keeper: Keeper | None = None
) -> RealGround:
    """Levels of all sets. progress: (tiles read, of how many). keeper: keeps what was read so far."""
    plans = _plans(sets, most_bytes)
    total, done = sum(len(plan.tiles) for plan in plans), 0
    levels: list[tuple[PageLevel, int, int]] = []
    for number, plan in enumerate(plans):
        if plan.factor > 1:
            log.warning(
                "%s: %s is read at 1/%d of its resolution, to fit into Terrain.height_map_most_mb = %g; raise it",
                what, plan.tiles.folder.folder, plan.factor, most_bytes / 1e6,
            )  # fmt: skip

        def report(tiles: int, before: int = done) -> None:
            if progress is not None:
                progress(before + tiles, total)

        found = _levels(_read(plan, number, what, report, keeper), plan.factor == 1)
        levels += [(level, factor, number) for level, factor in found]
        done += len(plan.tiles)
    if not levels:
        raise TileError(f"{what}: none of the {total} tiles has a height; fetch them again")
    if len(levels) > MOST_LEVELS:
        raise TileError(
            f"{what}: {len(sets)} sets of tiles of different resolutions make {len(levels)} levels; expected at most "
            f"{MOST_LEVELS}: remove the sets that others cover"
        )
    levels.sort(key=lambda found: found[0].lattice.step_deg)
    low = min(float(level.heights.min()) for level, _, _ in levels)
    high = max(float(level.heights.max()) for level, _, _ in levels)
    of_set = [number for _, _, number in levels]
    room = 0.05 * max(high - low, 1.0)
    return RealGround(
        tuple(level for level, _, _ in levels),
        tuple(factor for _, factor, _ in levels),
        tuple(of_set.index(number) for number in of_set),
        low - room,
        high + room,
    )


def _plans(sets: Sequence[TileSet], most_bytes: int) -> list[_Plan]:
    """The largest set gives way until all fit."""
    plans = [_Plan(found, 1) for found in sets]
    lattices = [found.lattice for found in sets]
    while True:
        bytes_of = [_bytes(plan) for plan in plans]
        largest = int(np.argmax(bytes_of))
        factor = factor_of(lattices[largest])
        if sum(bytes_of) <= most_bytes or not factor or bytes_of[largest] <= 16 * _SLOT_BYTES:
            return plans
        lattices[largest] = lattices[largest].coarser(factor)
        plans[largest] = _Plan(plans[largest].tiles, plans[largest].factor * factor)


def _bytes(plan: _Plan) -> int:
    """About what a set takes, with its coarser levels and its borders."""
    samples = plan.tiles.samples / plan.factor**2
    side = max(samples, 1.0) ** 0.5 / BLOCK
    return int((1.08 * samples / BLOCK**2 + 8.0 * side + 8.0) * _SLOT_BYTES)


def _read(plan: _Plan, number_of_set: int, what: str, report: Callable[[int], None], keeper: Keeper | None) -> RawLevel:
    """The finest level of a set: samples as they are, or means of squares of them."""
    tiles, factor = plan.tiles, plan.factor
    lattice = tiles.lattice
    found = RawLevel(lattice)
    if factor > 1:
        left = factor
        while left > 1:
            step = factor_of(lattice)
            lattice, left = lattice.coarser(step), left // step
        found = RawLevel(lattice)
    water = water_of(tiles.folder, what)
    began = None if keeper is None else keeper.began(number_of_set)
    first = 0
    if began is not None:
        first, found = began
    for number in range(first, len(tiles)):
        file, where = tiles.tile(number)
        try:
            values = read_tile(file, where, tiles.folder.png)
        except (TileError, OSError) as error:
            log.warning("%s: %s (left out)", what, error)
            continue
        if tiles.folder.geoid_m:
            values = values + np.float32(tiles.folder.geoid_m)
        if water is not None:
            values = water.lowered(values, where)
        if factor == 1:
            found.place(values, where.column, where.row)
        else:
            found.add(*_blocks(values, where.column, where.row, factor))
        report(number + 1)
        if keeper is not None:
            keeper.keep(number_of_set, number + 1, found)
    found.finish()
    return found


def _blocks(
    values: NDArray[np.float32], column: int, row: int, factor: int
) -> tuple[NDArray[np.float32], NDArray[np.uint16], int, int]:
    """Sums and counts of squares of samples, and the first square (column, row)."""
    before = row % factor, column % factor
    after = tuple(-(n + b) % factor for n, b in zip(values.shape, before, strict=True))
    wide = np.pad(values, tuple(zip(before, after, strict=True)), constant_values=np.nan)
    there = ~np.isnan(wide)
    shape = wide.shape[0] // factor, factor, wide.shape[1] // factor, factor
    sums = np.where(there, wide, 0.0).reshape(shape).sum(axis=(1, 3), dtype=np.float64).astype(np.float32)
    counts = there.reshape(shape).sum(axis=(1, 3)).astype(np.uint16)
    return sums, counts, column // factor, row // factor


def _levels(raw: RawLevel, exact: bool) -> list[tuple[PageLevel, int]]:
    """Pages of a set's levels, and how many times finer each is than the next."""
    raws, factors = [raw], []
    while raws[-1].lattice.step_deg < _WIDEST_STEP_DEG and raws[-1].blocks:
        factor = factor_of(raws[-1].lattice)
        if not factor:
            break
        factors.append(factor)
        raws.append(raws[-1].coarser(factor))
    factors.append(0)
    found: list[tuple[PageLevel, int]] = []
    coarser: PageLevel | None = None
    for number in range(len(raws) - 1, -1, -1):
        level = pages_of(raws[number], None if coarser is None else _heights_of(coarser), exact and number == 0)
        if level is None:
            return []
        found.append((level, factors[number]))
        coarser = level
    return found


def _heights_of(level: PageLevel) -> Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]:
    def heights(latitude_deg: NDArray[np.float64], longitude_deg: NDArray[np.float64]) -> NDArray[np.float64]:
        world = World(directions_at(latitude_deg, longitude_deg))
        out = np.full(len(latitude_deg), np.nan)
        found = sample_level(level, world, np.arange(len(out)))
        if found is not None:
            out[found.at] = found.height
        return out

    return heights
