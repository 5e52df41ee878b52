"""From tiles of pictures to levels of pages that fit into memory: each set at the finest resolution it can have."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from functools import lru_cache
from pathlib import Path
from threading import Lock
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import NDArray

from ..display import BETWEEN, reflectance
from ..srgb import SRGB_STEPS, srgb_decode
from ..wavelengths import Nanometres
from .color_files import read_color_tile
from .color_ground import SLOT, ColorGround, ColorPages, ColorSet, pages_of_colors
from .color_level import SIDE, ColorLevel, decoded, pixel_factor
from .color_margins import MARGIN, with_margins
from .color_unlit import Relief, take_out_sun
from .found import Found, TileError, pieces
from .kept_colors import KeptColors
from .tile_folders import COLORS
from .tile_index import TileSet, open_tiles, tiles_stamp

__all__ = ["color_levels", "color_plans", "make_colors", "read_pixels", "real_colors", "require_relief", "roots_of"]

log = logging.getLogger(__name__)

Pixels = NDArray[np.uint8]
Convert = Callable[[Pixels], Pixels]
Progress = Callable[[int, int], None]

_WIDEST_STEP_DEG = 1.0
"""Levels end at pixels so far apart: from farther away no planet is seen in pixels of 0.6 degrees."""
_TABLE = 33
"""Steps of a channel in the table of reflectances; between them it is linear."""
_PAGE_BYTES = 4 * SLOT * SLOT
_reading = Lock()
_in_use: WeakValueDictionary[tuple[object, ...], ColorGround] = WeakValueDictionary()
_last: list[ColorGround] = []


def real_colors(
    path: str, nm: Nanometres, most_bytes: int, what: str, unlit: float = 0.0, relief: Relief | None = None
) -> ColorGround:
    """The map of pictures at `path` as reflectances at the wavelengths `nm`, read once as long as its files stay as
    they are, in at most about so many bytes. unlit: share of the sun's shading that is taken out, by `relief`.
    TileError says what is wrong."""
    require_relief(unlit, relief, what)
    stamp = (tiles_stamp(path, COLORS), nm, most_bytes, unlit, relief.stamp if relief and unlit > 0.0 else None)
    with _reading:
        found = _in_use.get(stamp)
        if found is None:
            found = KeptColors(stamp[:3]).load() if unlit == 0.0 else None
            if found is None:
                sets = open_tiles(path, what, kind=COLORS)
                found = _color_ground(sets, nm, most_bytes, what, unlit, relief)
            _in_use[stamp] = found
        _last[:] = [found]  # the next one who asks has it, too
    return found


def make_colors(
    path: str, nm: Nanometres, most_bytes: int, what: str, progress: Progress | None = None
) -> tuple[ColorGround, Path]:
    """Read the map at `path` and keep its levels, so that scenes start at once; and the file they are in. progress:
    (tiles read, of how many). TileError says what is wrong."""
    keeper = KeptColors((tiles_stamp(path, COLORS), nm, most_bytes))
    if keeper.file is None:
        raise TileError(f"{what}: there is no cache folder (PLANETFALL_CACHE is empty); unset it, or name a folder")
    found = keeper.load()
    if found is None:
        sets = open_tiles(path, what, progress, COLORS)
        found = _color_ground(sets, nm, most_bytes, what, 0.0, None, progress)
        if not keeper.save(found):
            raise TileError(
                f"{what}: {keeper.file} can't be written; make room, or set PLANETFALL_CACHE to another folder"
            )
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


def color_plans(sets: Sequence[TileSet], most_bytes: int) -> list[tuple[TileSet, int]]:
    """Sets, and how many of their pixels make one; the largest gives way until all fit."""
    factors, lattices = [1] * len(sets), [found.lattice for found in sets]
    while True:
        bytes_of = [_bytes(found.samples / factor**2) for found, factor in zip(sets, factors, strict=True)]
        largest = int(np.argmax(bytes_of))
        factor = pixel_factor(lattices[largest])
        if sum(bytes_of) <= most_bytes or not factor or bytes_of[largest] <= 16 * _PAGE_BYTES:
            return list(zip(sets, factors, strict=True))
        lattices[largest] = lattices[largest].coarser(factor)
        factors[largest] *= factor


def _bytes(pixels: float) -> int:
    """About what a set takes, with its coarser levels and its margins."""
    side = max(pixels, 1.0) ** 0.5 / SIDE
    return int((4.0 / 3.0 * (side + 1.0) ** 2 + 8.0 * side * MARGIN / SIDE + 16.0) * _PAGE_BYTES)


def read_pixels(
    tiles: TileSet, factor: int, convert: Convert, what: str, report: Callable[[int], None] | None = None
) -> ColorLevel:
    """The finest level of a set: pixels as they are, or means of squares of them. convert: colours as files hold them,
    (..., 4), into what levels hold. report: is told how many tiles have been read."""
    lattice, left = tiles.lattice, factor
    while left > 1:
        step = pixel_factor(lattice)
        lattice, left = lattice.coarser(step), left // step
    level = ColorLevel(lattice)
    for number in range(len(tiles)):
        file, where = tiles.tile(number)
        try:
            for piece in pieces(where):
                pixels = convert(read_color_tile(file, piece))
                if factor == 1:
                    level.place(pixels, piece.column, piece.row)
                else:
                    _add(level, pixels, piece, factor)
        except (TileError, OSError) as error:
            log.warning("%s: %s (left out)", what, error)
            continue
        if report is not None:
            report(number + 1)
    if factor > 1:
        level.whole()
    return level


def _add(level: ColorLevel, pixels: Pixels, where: Found, factor: int) -> None:
    before = where.row % factor, where.column % factor
    after = tuple(-(n + b) % factor for n, b in zip(pixels.shape[:2], before, strict=True))
    wide = np.pad(pixels, (*zip(before, after, strict=True), (0, 0)))
    rows, columns = wide.shape[0] // factor, wide.shape[1] // factor
    means = decoded(wide).reshape(rows, factor, columns, factor, 4).mean(axis=(1, 3))
    level.add(means, where.column // factor, where.row // factor)


def color_levels(finest: ColorLevel) -> tuple[tuple[ColorPages, ...], tuple[float, ...]]:
    """Pages of a level and of coarser ones, and by how many octaves each is coarser."""
    found: list[ColorPages] = []
    octaves = [0.0]
    level = finest
    while True:
        level.round_poles()
        pages = pages_of_colors(level)
        if pages is None:
            break
        found.append(pages)
        factor = pixel_factor(level.lattice)
        if level.lattice.step_deg >= _WIDEST_STEP_DEG or not factor:
            break
        octaves.append(octaves[-1] + float(np.log2(factor)))
        level = level.coarser(factor)
    return tuple(found), tuple(octaves[: len(found)])


def roots_of(pixels: Pixels, nm: Nanometres) -> Pixels:
    """What levels hold of sRGB colours (..., 4) as reflectances at the wavelengths `nm`: gaps are 0 all over."""
    out = np.empty(pixels.shape, np.uint8)
    if nm in BETWEEN:
        out[..., :3] = _looked_up(pixels[..., :3], _root_table(nm))
    else:  # a matrix
        out[..., :3] = np.rint(255.0 * np.sqrt(reflectance(SRGB_STEPS[pixels[..., :3]], nm)))
    out[..., 3] = pixels[..., 3]
    out[pixels[..., 3] == 0] = 0
    return out


@lru_cache(maxsize=4)
def _root_table(nm: Nanometres) -> NDArray[np.float32]:
    """Square roots of reflectances at the wavelengths `nm`, (n, n, n, 3), of sRGB values in n even steps."""
    steps = srgb_decode(np.linspace(0.0, 1.0, _TABLE))
    colors = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
    return np.sqrt(reflectance(colors, nm)).astype(np.float32).reshape(_TABLE, _TABLE, _TABLE, 3)


def _looked_up(colors: Pixels, table: NDArray[np.float32]) -> NDArray[np.float32]:
    """Steps of 255 (..., 3), linear between the table's."""
    at = colors.astype(np.float32) * np.float32((_TABLE - 1) / 255.0)
    low = np.minimum(at.astype(np.int64), _TABLE - 2)
    f = at - low
    flat = table.reshape(-1, 3)
    first = (low[..., 0] * _TABLE + low[..., 1]) * _TABLE + low[..., 2]
    total = np.zeros(colors.shape, np.float32)
    for corner in range(8):
        bits = np.array([corner >> 2 & 1, corner >> 1 & 1, corner & 1])
        share = np.prod(np.where(bits, f, 1.0 - f), axis=-1)
        step = int((bits[0] * _TABLE + bits[1]) * _TABLE + bits[2])
        total += share[..., None] * flat[first + step]
    return np.rint(255.0 * np.clip(total, 0.0, 1.0))
