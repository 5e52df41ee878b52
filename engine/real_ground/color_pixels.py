"""From tiles of pictures to pixels of levels: plans that fit into memory, reading, coarser levels, reflectances."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..display import BETWEEN, reflectance
from ..srgb import SRGB_STEPS, srgb_decode
from ..wavelengths import Nanometres
from .color_files import read_color_tile
from .color_ground import SLOT, ColorPages, pages_of_colors
from .color_level import SIDE, ColorLevel, decoded, pixel_factor
from .color_margins import MARGIN
from .found import Found, TileError, pieces
from .lattice import Lattice
from .tile_index import TileSet

__all__ = ["color_levels", "color_plans", "level_bytes", "next_pixels", "read_pixels", "roots_of"]

log = logging.getLogger(__name__)

Pixels = NDArray[np.uint8]
Convert = Callable[[Pixels], Pixels]

_WIDEST_STEP_DEG = 1.0
"""Levels end at pixels so far apart: from farther away no planet is seen in pixels of 0.6 degrees."""
_TABLE = 33
"""Steps of a channel in the table of reflectances; between them it is linear."""
_PAGE_BYTES = 4 * SLOT * SLOT


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


def level_bytes(pixels: float) -> int:
    """About what a level takes, with its margins."""
    side = max(pixels, 1.0) ** 0.5 / SIDE
    return int((side + 1.5) ** 2 * _PAGE_BYTES)


def next_pixels(lattice: Lattice) -> int:
    """How many pixels of a level make one of the next; 0: it is the last."""
    return pixel_factor(lattice) if lattice.step_deg < _WIDEST_STEP_DEG else 0


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
        factor = next_pixels(level.lattice)
        if not factor:
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
