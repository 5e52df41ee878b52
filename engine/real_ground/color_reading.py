"""Maps of pictures of the ground: in memory whole, page by page, or each set at the finest resolution it can have."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from threading import Lock
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import NDArray

from ..wavelengths import Nanometres
from .color_ground import ColorGround, ColorSet
from .color_margins import with_margins
from .color_pixels import color_levels, color_plans, level_bytes, next_pixels, read_pixels, roots_of
from .color_unlit import Relief, take_out_sun
from .found import TileError
from .kept_colors import KeptColors
from .streamed_colors import ColorStreamFiles, Reading, StreamedColors, streamed_colors
from .streamed_ground import first_in_memory
from .tile_folders import COLORS
from .tile_index import TileSet, open_tiles, tiles_stamp

__all__ = ["forget_colors", "make_colors", "real_colors", "require_relief"]

log = logging.getLogger(__name__)

Pixels = NDArray[np.uint8]
Progress = Callable[[int, int], None]

_UNWRITTEN = "{} can't be written; make room, or set PLANETFALL_CACHE to another folder"
_reading = Lock()
_in_use: WeakValueDictionary[tuple[object, ...], ColorGround] = WeakValueDictionary()
_last: list[ColorGround] = []


def real_colors(
    path: str, nm: Nanometres, most_bytes: int, what: str, unlit: float = 0.0, relief: Relief | None = None,
    streams: bool = False,
) -> ColorGround:  # fmt: skip
    """The map of pictures at `path` as reflectances at the wavelengths `nm`, read once as long as its files stay as
    they are, in at most about so many bytes. unlit: share of the sun's shading that is taken out, by `relief`.
    streams: where more is wanted, fine levels are read as they are asked for (StreamedColors); else sets are read
    coarser. TileError says what is wrong."""
    require_relief(unlit, relief, what)
    of_relief = relief.stamp if relief and unlit > 0.0 else None
    stamp = (tiles_stamp(path, COLORS), nm, most_bytes, unlit, of_relief, streams)
    with _reading:
        found = _in_use.get(stamp)
        if found is None:
            found = _read_colors(path, stamp[:3], nm, most_bytes, what, unlit, relief, streams)
            _in_use[stamp] = found
            if not isinstance(found, StreamedColors):
                _in_use[(*stamp[:-1], False)] = found
        _last[:] = [found]  # the next one who asks has it, too
    return found


def forget_colors() -> None:
    """The next who asks for a map gets it anew from disk; those who hold one keep it."""
    with _reading:
        _in_use.clear()
        _last.clear()


def _read_colors(
    path: str, stamp: tuple[object, ...], nm: Nanometres, most_bytes: int, what: str, unlit: float,
    relief: Relief | None, streams: bool,
) -> ColorGround:  # fmt: skip
    sets: Sequence[TileSet] | None = None
    if streams:
        sets = open_tiles(path, what, kind=COLORS)
        firsts = _firsts(sets, most_bytes)
        if any(firsts):
            return _streamed(sets, firsts, stamp, nm, most_bytes, what, unlit, relief)
    found = KeptColors(stamp).load() if unlit == 0.0 else None
    if found is None:
        sets = sets or open_tiles(path, what, kind=COLORS)
        found = _color_ground(sets, nm, most_bytes, what, unlit, relief)
    return found


def _firsts(sets: Sequence[TileSet], most_bytes: int) -> list[int]:
    """Of each set the finest level that is in memory whole: 0 where all are as fine as their files."""
    if all(factor == 1 for _, factor in color_plans(sets, most_bytes)):
        return [0] * len(sets)
    return first_in_memory(sets, most_bytes, level_bytes, next_pixels)


def _streamed(
    sets: Sequence[TileSet], firsts: Sequence[int], stamp: tuple[object, ...], nm: Nanometres, most_bytes: int,
    what: str, unlit: float, relief: Relief | None, progress: Progress | None = None,
) -> StreamedColors:  # fmt: skip
    known: tuple[object, ...] | None = (stamp[0], nm)
    if unlit > 0.0 and relief is not None:
        known = None if relief.files is None else (stamp[0], nm, unlit, relief.files)
    files = ColorStreamFiles(known, most_bytes)
    reading = Reading(partial(roots_of, nm=nm), unlit, relief, what, color_levels)
    found = streamed_colors(sets, firsts, files, reading, most_bytes, progress)
    if not found.sets:
        raise TileError(f"{what}: none of the {sum(map(len, sets))} tiles has a pixel; fetch them again")
    return found


def make_colors(
    path: str, nm: Nanometres, most_bytes: int, what: str, progress: Progress | None = None, streams: bool = False
) -> tuple[ColorGround, Path]:
    """Read the map at `path` and keep its levels, so that scenes start at once; and the file they are in. progress:
    (tiles read, of how many). streams: as for real_colors. TileError says what is wrong."""
    stamp = (tiles_stamp(path, COLORS), nm, most_bytes)
    keeper = KeptColors(stamp)
    if keeper.file is None:
        raise TileError(f"{what}: there is no cache folder (PLANETFALL_CACHE is empty); unset it, or name a folder")
    if streams:
        sets = open_tiles(path, what, progress, COLORS)
        firsts = _firsts(sets, most_bytes)
        if any(firsts):
            made = _streamed(sets, firsts, stamp, nm, most_bytes, what, 0.0, None, progress)
            if made.index is None or not made.index.exists():
                raise TileError(f"{what}: {_UNWRITTEN.format(made.index)}")
            return made, made.index
    found = keeper.load()
    if found is None:
        sets = open_tiles(path, what, progress, COLORS)
        found = _color_ground(sets, nm, most_bytes, what, 0.0, None, progress)
        if not keeper.save(found):
            raise TileError(f"{what}: {_UNWRITTEN.format(keeper.file)}")
    return found, keeper.file


def require_relief(unlit: float, relief: Relief | None, what: str) -> None:
    """TileError if the sun is to be taken out of pictures of ground that nobody knows."""
    if unlit > 0.0 and relief is None:
        raise TileError(
            f"{what}_unlit: {unlit:g} without a height map: the sun is taken out of a picture by the ground's relief "
            "there; name Terrain.height_map, or set it to 0"
        )


def _color_ground(
    sets: Sequence[TileSet], nm: Nanometres, most_bytes: int, what: str, unlit: float, relief: Relief | None,
    progress: Progress | None = None,
) -> ColorGround:  # fmt: skip
    def convert(pixels: Pixels) -> Pixels:
        return roots_of(pixels, nm)

    found: list[ColorSet] = []
    total, done = sum(map(len, sets)), 0

    def report(tiles: int) -> None:
        if progress is not None:
            progress(done + tiles, total)

    for tiles, factor in color_plans(sets, most_bytes):
        if factor > 1:
            log.warning(
                "%s: %s is read at 1/%d of its resolution, to fit into Terrain.color_map_most_mb = %g; raise it",
                what, tiles.folder.folder, factor, most_bytes / 1e6,
            )  # fmt: skip
        level = read_pixels(tiles, factor, convert, what, report)
        done += len(tiles)
        if not level.blocks:
            continue
        sun_deg = None
        if unlit > 0.0 and relief is not None:
            sun_deg = take_out_sun(level, relief, tiles.folder.sun_deg, unlit)
            if sun_deg is not None and tiles.folder.sun_deg is None:
                log.info(
                    "%s: %s: the sun stood at %.0f degrees from north, %.0f high", what, tiles.folder.folder, *sun_deg
                )
        levels, octaves = color_levels(with_margins(level))
        found.append(ColorSet(levels, octaves, sun_deg))
    if not found:
        count = sum(map(len, sets))
        raise TileError(f"{what}: none of the {count} tiles has a pixel; fetch them again")
    return ColorGround(tuple(found))
