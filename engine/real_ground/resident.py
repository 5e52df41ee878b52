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

from .found import TileError, pieces
from .kept_ground import Keeper
from .page_levels import levels_of
from .pages import SLOT, PageLevel
from .raw_level import BLOCK, RawLevel, factor_of
from .real_ground import RealGround
from .streamed_ground import KeptStream, SetLevels, StreamedGround, ground_of, levels_in_memory, read_set
from .tile_files import read_tile
from .tile_index import TileSet, open_tiles, tiles_stamp
from .water_mask import water_of

__all__ = [
    "MOST_LEVELS",
    "files_of",
    "forget_ground",
    "make_ground",
    "real_ground",
    "resident_ground",
    "streamed_ground",
]

log = logging.getLogger(__name__)

Progress = Callable[[int, int], None]
MOST_LEVELS = 24
"""Of all sets together: the GPU has room for so many."""
_SLOT_BYTES = 4 * SLOT * SLOT
_reading = Lock()
_in_use: WeakValueDictionary[tuple[int, tuple[object, ...], bool], RealGround] = WeakValueDictionary()
"""All that somebody still holds, however many planets have tiles, and the last one that was asked for."""
_last: list[RealGround] = []


def real_ground(path: str, most_bytes: int, what: str, streams: bool = False) -> RealGround:
    """The map at `path`, read once as long as its files stay as they are, in at most about so many bytes. streams:
    where more is wanted, fine levels are read as they are asked for (StreamedGround); else sets are read coarser.
    TileError says what is wrong."""
    stamp = tiles_stamp(path)
    with _reading:
        found = _in_use.get((most_bytes, stamp, streams))
        if found is None:
            found = _read_ground(path, stamp, most_bytes, what, streams)
            _in_use[most_bytes, stamp, streams] = found
            if not isinstance(found, StreamedGround):
                _in_use[most_bytes, stamp, False] = found
        _last[:] = [found]
    return found


def forget_ground() -> None:
    """The next who asks for a map gets it anew from disk; those who hold one keep it."""
    with _reading:
        _in_use.clear()
        _last.clear()


def files_of(ground: RealGround) -> tuple[object, ...] | None:
    """What tells other processes whether the files of a map are the same; None of ground that was not read here."""
    with _reading:
        known = ((most, stamp, streams) for (most, stamp, streams), each in _in_use.items() if each is ground)
        return min(known, key=repr, default=None)


def _read_ground(path: str, stamp: tuple[object, ...], most_bytes: int, what: str, streams: bool) -> RealGround:
    found = _in_use.get((most_bytes, stamp, False)) or Keeper(stamp, most_bytes).load()
    if found is not None and (not streams or _is_whole(found)):
        return found
    sets = open_tiles(path, what)
    if not streams or _fit(sets, most_bytes):
        return found or resident_ground(sets, most_bytes, what)
    return streamed_ground(sets, stamp, most_bytes, what)


def _is_whole(ground: RealGround) -> bool:
    """Whether all sets are there as fine as their files."""
    return all(ground.levels[k].finest for k in set(ground.finest_of))


def _fit(sets: Sequence[TileSet], most_bytes: int) -> bool:
    """Whether all sets are in memory as fine as their files."""
    return all(plan.factor == 1 for plan in _plans(sets, most_bytes)) or not any(levels_in_memory(sets, most_bytes))


def make_ground(
    path: str, most_bytes: int, what: str, progress: Progress | None = None, streams: bool = False
) -> tuple[RealGround, Path]:
    """Read the map at `path` and keep its levels, so that scenes start at once; and the file they are in. What was cut
    off goes on where it was. streams: as for real_ground. TileError says what is wrong."""
    stamp = tiles_stamp(path)
    keeper = Keeper(stamp, most_bytes)
    file = keeper.file
    if file is None:
        raise TileError(f"{what}: there is no cache folder (PLANETFALL_CACHE is empty); unset it, or name a folder")
    found = keeper.load()
    if found is None or (streams and not _is_whole(found)):
        sets = open_tiles(path, what, progress)
        if streams and not _fit(sets, most_bytes):
            found = streamed_ground(sets, stamp, most_bytes, what, progress)
            written = found.index if found.index is not None and found.index.exists() else None
        else:
            found = found or resident_ground(sets, most_bytes, what, progress, keeper)
            written = keeper.save(found)
        if written is None:
            raise TileError(f"{what}: {file} can't be written; make room, or set PLANETFALL_CACHE to another folder")
        file = written
    return found, file


def streamed_ground(
    sets: Sequence[TileSet], stamp: tuple[object, ...], most_bytes: int, what: str, progress: Progress | None = None
) -> StreamedGround:
    """As it was kept, or with all tiles read once. stamp: of tiles_stamp."""
    kept = KeptStream(stamp, most_bytes)
    found = kept.load(sets)
    if found is None:
        found = [
            read_set(tiles, first, kept, number, what, progress) if first else _set_in_memory(tiles, number, what)
            for number, (tiles, first) in enumerate(zip(sets, levels_in_memory(sets, most_bytes), strict=True))
        ]
        kept.save(found)
    levels = sum(len(each.streamed) + len(each.whole) for each in found if each.whole)
    _check(levels, sets, what)
    return ground_of(found, kept, most_bytes, what)


def _set_in_memory(tiles: TileSet, number: int, what: str) -> SetLevels:
    return SetLevels(tiles, (), levels_of(_read(_Plan(tiles, 1), number, what, lambda done: None, None), True))


def _check(levels: int, sets: Sequence[TileSet], what: str) -> None:
    if not levels:
        raise TileError(f"{what}: none of the {sum(map(len, sets))} tiles has a height; fetch them again")
    if levels > MOST_LEVELS:
        raise TileError(
            f"{what}: {len(sets)} sets of tiles of different resolutions make {levels} levels; expected at most "
            f"{MOST_LEVELS}: remove the sets that others cover"
        )


@dataclass(frozen=True)
class _Plan:
    """A set, and how many samples of its files make one of its finest level."""

    tiles: TileSet
    factor: int


def resident_ground(
    sets: Sequence[TileSet],
    most_bytes: int,
    what: str,
    progress: Progress | None = None,
    keeper: Keeper | None = None,
    quiet: bool = False,
) -> RealGround:
    """Levels of all sets. progress: (tiles read, of how many). keeper: keeps what was read so far. quiet: no word of
    sets that are read coarser."""
    plans = _plans(sets, most_bytes)
    total, done = sum(len(plan.tiles) for plan in plans), 0
    levels: list[tuple[PageLevel, int, int]] = []
    for number, plan in enumerate(plans):
        if plan.factor > 1 and not quiet:
            log.warning(
                "%s: %s is read at 1/%d of its resolution, to fit into Terrain.height_map_most_mb = %g; raise "
                "it, or read it as it is looked at, with Terrain.backend = 'grid'",
                what, plan.tiles.folder.folder, plan.factor, most_bytes / 1e6,
            )  # fmt: skip

        def report(tiles: int, before: int = done) -> None:
            if progress is not None:
                progress(before + tiles, total)

        found = levels_of(_read(plan, number, what, report, keeper), plan.factor == 1)
        levels += [(level, factor, number) for level, factor in found]
        done += len(plan.tiles)
    _check(len(levels), sets, what)
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
            for piece in pieces(where):
                values = read_tile(file, piece, tiles.folder.png)
                if tiles.folder.geoid_m:
                    values = values + np.float32(tiles.folder.geoid_m)
                if water is not None:
                    values = water.lowered(values, piece)
                if factor == 1:
                    found.place(values, piece.column, piece.row)
                else:
                    found.add(*_blocks(values, piece.column, piece.row, factor))
        except (TileError, OSError) as error:
            log.warning("%s: %s (left out)", what, error)
            continue
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
