"""The GPU's copy of pictures of the ground: one texture of words, laid out as assets/shaders/terrain/real_colors.glsl
reads it.

Words come first, row by row, then slots of pages, side by side, a word a pixel. Word 0 is the number of levels of all
sets. From _FIRST_LEVEL on there are _LEVEL words a level (_level_words), then of each level a table of pages by hash,
twice as long as there are pages or more, -1: none, and a record a page:

    0, 1   row and column of the page
    2      its slot
    3, 4   row and column in the page of a pixel whose place is known
    5-10   that place: whole parts in the height function's units (3), what is left of them (3, float)
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...components import Terrain
from ...engine.made_shaders import made_shader
from ...engine.real_ground.color_ground import BEFORE, SLOT, WHOLE, ColorGround, ColorPages, ColorSet
from ...engine.real_ground.color_level import SIDE
from ...engine.real_ground.color_reading import real_colors, require_relief
from ...engine.real_ground.color_unlit import Relief
from ...engine.real_ground.lattice import directions_at
from ...engine.real_ground.real_ground import RealGround
from ...engine.real_ground.tile_folders import COLORS
from ...engine.real_ground.tile_index import open_tiles
from ...engine.surface.cube_map import CubeMap
from ...engine.wavelengths import Nanometres
from .height_map import HeightMap, color_cube, map_values
from .height_params import TerrainParams
from .real_texture import fixed_unit_m

__all__ = ["check_pictures", "color_texels", "ground_colors", "pictured_width_bits", "relief_of", "write_anchor"]

Floats = NDArray[np.float64]
Words = NDArray[np.int32]

_FIRST_LEVEL, _LEVEL, _RECORD = 8, 16, 11
_SLOT_BITS = SLOT.bit_length() - 1
_MOST_ROWS = 16384
_WHAT = "Terrain.color_map"


def _shader() -> str:
    numbers: dict[str, Any] = {
        "SIDE": SIDE, "BEFORE": BEFORE, "SLOT_BITS": _SLOT_BITS, "FIRST_LEVEL": _FIRST_LEVEL, "LEVEL": _LEVEL,
        "WHOLE": WHOLE,
    }  # fmt: skip
    return "".join(f"const {type(v).__name__} COLORS_{name} = {v};\n" for name, v in numbers.items())


made_shader("generated/terrain_color_numbers.glsl", _shader)


def ground_colors(terrain: Terrain, params: TerrainParams, nm: Nanometres) -> CubeMap | ColorGround | None:
    """The colours that a Terrain component names, all around or as tiles. SettingError says what is wrong."""
    if not params.pictured:
        return color_cube(terrain.color_map, nm) if terrain.color_map else None
    most_bytes, unlit = int(1e6 * terrain.color_map_most_mb), terrain.color_map_unlit
    return real_colors(terrain.color_map, nm, most_bytes, _WHAT, unlit, relief_of(params))


def check_pictures(terrain: Terrain, params: TerrainParams) -> None:
    """SettingError says what is wrong with the tiles of pictures that a Terrain component names. Reads no pixel."""
    require_relief(terrain.color_map_unlit, relief_of(params), _WHAT)
    open_tiles(terrain.color_map, _WHAT, kind=COLORS, quiet=True)


def relief_of(params: TerrainParams) -> Relief | None:
    """The ground where maps say how high it is."""
    radius_m, real, found = params.radius_m, params.real, params.height_map

    def of_tiles(directions: Floats, real: RealGround) -> Floats:
        height, rest = real.heights(directions * radius_m)
        return np.where(rest > 0.5, np.nan, height)

    def of_map(directions: Floats, found: HeightMap) -> Floats:
        return map_values(found, directions)[0]

    if real is not None:
        return Relief(partial(of_tiles, real=real), real.finest_m(radius_m), radius_m, (real, radius_m))
    if found is not None:
        return Relief(partial(of_map, found=found), found.sample_rad * radius_m, radius_m, (found, radius_m))
    return None


def pictured_width_bits(found: ColorGround) -> int:
    """Of the texture's rows."""
    pages, bits = _pages(found), _SLOT_BITS + 4
    while bits < 14 and -(-pages >> (bits - _SLOT_BITS)) * SLOT > _MOST_ROWS // 2:
        bits += 1
    return bits


def _pages(found: ColorGround) -> int:
    return sum(len(level.where) for each in found.sets for level in each.levels)


def color_texels(found: ColorGround, radius_m: float) -> NDArray[np.uint32]:
    """Texels (rows, columns) of words."""
    bits = pictured_width_bits(found)
    width, across = 1 << bits, 1 << (bits - _SLOT_BITS)
    count = sum(len(each.levels) for each in found.sets)
    tables = [_hashed(level) for each in found.sets for level in each.levels]
    end = _FIRST_LEVEL + _LEVEL * count + sum(len(table) for table in tables) + _RECORD * _pages(found)
    rows = -(-end // (width * SLOT)) * SLOT
    texels = np.zeros((rows + -(-_pages(found) // across) * SLOT, width), np.uint32)
    words = texels[:rows].reshape(-1).view(np.int32)
    words[0] = count
    at, number, slot = _FIRST_LEVEL + _LEVEL * count, 0, rows // SLOT * across
    for each in found.sets:
        for k, level in enumerate(each.levels):
            table = tables[number]
            first_record = at + len(table)
            header = _FIRST_LEVEL + _LEVEL * number
            words[header : header + _LEVEL] = _level_words(each, k, at, len(table))
            words[at:first_record] = np.where(table < 0, -1, first_record + _RECORD * table)
            at = first_record + _RECORD * len(level.where)
            words[first_record:at] = _records(level, radius_m, slot).ravel()
            for page in level.pixels:
                row, column = slot // across * SLOT, slot % across * SLOT
                texels[row : row + SLOT, column : column + SLOT] = np.ascontiguousarray(page).view("<u4")[..., 0]
                slot += 1
            number += 1
    return texels


def _level_words(each: ColorSet, k: int, first: int, size: int) -> Words:
    """What the shader knows of level k of a set. first, size: of its table of pages."""
    level, words = each.levels[k], np.zeros(_LEVEL, np.int32)
    lattice = level.lattice
    by_angle = lattice.down / (2.0 * np.pi if lattice.mercator else np.pi)
    words[:7] = np.array(
        [lattice.across, lattice.down, lattice.phase_x, lattice.phase_y, lattice.across / (2.0 * np.pi), by_angle,
         each.octaves[k]],
        np.float32,
    ).view(np.int32)  # fmt: skip
    words[7:13] = (
        level.first_column, int(lattice.mercator), -(-lattice.period // SIDE), first, size - 1, len(each.levels) - k,
    )  # fmt: skip
    return words


def _hashed(level: ColorPages) -> NDArray[np.int64]:
    """Numbers of pages by the hash of their row and column, in the next place that is free."""
    size = 2
    while size < 2 * len(level.where):
        size *= 2
    table = np.full(size, -1, np.int64)
    for number, at in enumerate(_hash(level.where).tolist()):
        place = at & (size - 1)
        while table[place] >= 0:
            place = (place + 1) & (size - 1)
        table[place] = number
    return table


def _hash(where: NDArray[np.int64]) -> NDArray[np.uint32]:
    """As colors_hash() of the shader."""
    row, column = where.astype(np.uint32).T
    found = row * np.uint32(2654435761) ^ column * np.uint32(2246822519)
    found = (found ^ found >> np.uint32(15)) * np.uint32(2654435769)
    return found ^ found >> np.uint32(13)


def _records(level: ColorPages, radius_m: float, first_slot: int) -> Words:
    """(pages, _RECORD). The pixel whose place is known is the page's middle, or the next one on this side of a pole."""
    lattice, count = level.lattice, len(level.where)
    row, column = (level.where * SIDE + SIDE // 2).T
    if not lattice.mercator:
        last = int(np.ceil(lattice.down - lattice.phase_y)) - 1
        row = np.clip(row, 0 if lattice.phase_y > 0.25 else 1, last)
    units = directions_at(*lattice.place(column, row)).T * (radius_m / fixed_unit_m(radius_m))
    whole = np.floor(units)
    words = np.zeros((count, _RECORD), np.int32)
    words[:, :2] = level.where
    words[:, 2] = first_slot + np.arange(count)
    words[:, 3], words[:, 4] = row - level.where[:, 0] * SIDE, column - level.where[:, 1] * SIDE
    words[:, 5:8] = whole
    words[:, 8:11] = np.ascontiguousarray((units - whole).astype(np.float32)).view(np.int32)
    return words


def write_anchor(table: NDArray[Any], point_m: NDArray[np.float64]) -> None:
    """Where the anchor (3,) of the height function's table is, in whole units and the rest."""
    unit_m = float(table["fixed_unit_m"])
    whole = np.floor(point_m / unit_m)
    table["real"]["place"], table["real"]["part"] = whole, point_m / unit_m - whole
