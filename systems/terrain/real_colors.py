"""The GPU's copy of pictures of the ground: one texture of words, laid out as assets/shaders/terrain/real_colors.glsl
reads it.

Words come first, row by row, then slots of pages, side by side, a word a pixel. Word 0 is the number of levels of all
sets. From _FIRST_LEVEL on there are _LEVEL words a level (_level_words), then of each level a table of pages by hash,
twice as long as there are pages or more, -1: none, and a record a page:

    0, 1   row and column of the page
    2      its slot
    3, 4   row and column in the page of a pixel whose place is known
    5-10   that place: whole parts in the height function's units (3), what is left of them (3, float)

Of levels that stream (color_stream.py) there are three words a page in place of records: row, column, and the word of
its record, -1: the page isn't there. Those records follow all other words, POOL_RECORD words each, with one more
number, one over the page's own columns; word 1 says where they begin. Last, from word 2's on, is what they weigh at
their corners, four numbers a record. Their slots are those after all others.
"""

from __future__ import annotations

from dataclasses import dataclass
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
from ...engine.real_ground.resident import files_of
from ...engine.real_ground.streamed_color_level import StreamedColorLevel
from ...engine.real_ground.streamed_colors import StreamedColors
from ...engine.real_ground.tile_folders import COLORS
from ...engine.real_ground.tile_index import open_tiles
from ...engine.surface.cube_map import CubeMap
from ...engine.wavelengths import Nanometres
from .height_map import HeightMap, color_cube, map_values
from .height_params import TerrainParams
from .real_texture import fixed_unit_m

__all__ = [
    "POOL_RECORD",
    "ColorLayout",
    "check_pictures",
    "color_layout",
    "color_texels",
    "ground_colors",
    "pictured_width_bits",
    "pool_record",
    "relief_of",
    "stub_word",
    "write_anchor",
]

Floats = NDArray[np.float64]
Words = NDArray[np.int32]

_FIRST_LEVEL, _LEVEL, _RECORD = 8, 16, 11
POOL_RECORD, _STUB = 16, 3
"""Words of a record of a level that streams: a power of two, so that none crosses rows of the texture; and of what its
table says of a page."""
_FEWEST = 32
_SLOT_BITS = SLOT.bit_length() - 1
_MOST_ROWS = 16384
_WHAT = "Terrain.color_map"


def _shader() -> str:
    numbers: dict[str, Any] = {
        "SIDE": SIDE, "BEFORE": BEFORE, "SLOT_BITS": _SLOT_BITS, "FIRST_LEVEL": _FIRST_LEVEL, "LEVEL": _LEVEL,
        "WHOLE": WHOLE, "POOL_RECORD": POOL_RECORD, "COLUMNS": _RECORD,
    }  # fmt: skip
    return "".join(f"const {type(v).__name__} COLORS_{name} = {v};\n" for name, v in numbers.items())


made_shader("generated/terrain_color_numbers.glsl", _shader)


def ground_colors(terrain: Terrain, params: TerrainParams, nm: Nanometres) -> CubeMap | ColorGround | None:
    """The colours that a Terrain component names, all around or as tiles. SettingError says what is wrong."""
    if not params.pictured:
        return color_cube(terrain.color_map, nm) if terrain.color_map else None
    most_bytes, unlit = int(1e6 * terrain.color_map_most_mb), terrain.color_map_unlit
    streams = terrain.method == "ours"  # pixels read them, so all ways to draw that ground do with what is there
    return real_colors(terrain.color_map, nm, most_bytes, _WHAT, unlit, relief_of(params), streams)


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
        files = files_of(real)
        known = None if files is None else (files, radius_m)
        return Relief(partial(of_tiles, real=real), real.finest_m(radius_m), radius_m, (real, radius_m), known)
    if found is not None:
        return Relief(partial(of_map, found=found), found.sample_rad * radius_m, radius_m, (found, radius_m))
    return None


@dataclass(frozen=True)
class ColorLayout:
    """width_bits of the texture; of each level the words where its table and its records begin, and how long the table
    is; rows of words, and of all. pool: slots of pages that come and go, the first of which is first_slot;
    first_record and first_fade: the words of their records and of what they weigh."""

    width_bits: int
    words: NDArray[np.int64]
    word_rows: int
    rows: int
    first_slot: int
    pool: int
    first_record: int
    first_fade: int

    def slot(self, slot: int) -> tuple[int, int]:
        """Column and row of the slot's first texel."""
        across = 1 << (self.width_bits - _SLOT_BITS)
        return slot % across * SLOT, slot // across * SLOT

    def place(self, word: int) -> tuple[int, int]:
        """Column and row of a word."""
        return word & ((1 << self.width_bits) - 1), word >> self.width_bits


def color_layout(found: ColorGround) -> ColorLayout:
    """Where in the texture what is."""
    levels = [level for each in found.sets for level in each.levels]
    whole = sum(len(level.pixels) for level in levels)
    budget = found.budget_bytes if isinstance(found, StreamedColors) else 0
    slots, bits = max(whole, budget // (4 * SLOT * SLOT)), _SLOT_BITS + (2 if budget else 4)
    while bits < 14 and -(-slots >> (bits - _SLOT_BITS)) * SLOT > _MOST_ROWS // 2:
        bits += 1
    words, at = np.zeros((len(levels), 3), np.int64), _FIRST_LEVEL + _LEVEL * len(levels)
    for number, level in enumerate(levels):
        streams = isinstance(level, StreamedColorLevel)
        size = _table_size(level)
        words[number] = at, at + size, size
        at += size + (_STUB if streams else _RECORD) * len(level.where)
    across, first_record, pool = 1 << (bits - _SLOT_BITS), -(-at // POOL_RECORD) * POOL_RECORD, 0

    def ends(pool: int) -> tuple[int, int]:
        """Of records and of all words."""
        fade = -(-(first_record + POOL_RECORD * pool) >> bits) << bits
        return fade, fade + (-(-4 * pool >> bits) << bits)

    def rows_of(pool: int) -> tuple[int, int]:
        word_rows = -(-(ends(pool)[1] if pool else at) // (SLOT << bits)) * SLOT
        return word_rows, word_rows + -(-(whole + pool) // across) * SLOT

    if budget:
        pool = budget // (4 * SLOT * SLOT) - whole
        while pool > _FEWEST and 4 * rows_of(pool)[1] << bits > budget:
            pool -= 1
        pool = max(pool, _FEWEST)
    word_rows, rows = rows_of(pool)
    first_slot = word_rows // SLOT * across + whole
    return ColorLayout(bits, words, word_rows, rows, first_slot, pool, first_record, ends(pool)[0])


def pictured_width_bits(found: ColorGround) -> int:
    """Of the texture's rows."""
    return color_layout(found).width_bits


def color_texels(found: ColorGround, radius_m: float) -> NDArray[np.uint32]:
    """Texels (rows, columns) of words, without any page that streams."""
    layout = color_layout(found)
    texels = np.zeros((layout.rows, 1 << layout.width_bits), np.uint32)
    words = texels[: layout.word_rows].reshape(-1).view(np.int32)
    words[:3] = len(layout.words), layout.first_record, layout.first_fade
    number, slot = 0, layout.first_slot - sum(len(level.pixels) for each in found.sets for level in each.levels)
    for each in found.sets:
        for k, level in enumerate(each.levels):
            table, (at, records, size) = _hashed(level), layout.words[number].tolist()
            header = _FIRST_LEVEL + _LEVEL * number
            words[header : header + _LEVEL] = _level_words(each, k, at, size)
            streams = isinstance(level, StreamedColorLevel)
            words[at:records] = np.where(table < 0, -1, records + (_STUB if streams else _RECORD) * table)
            made = _stubs(level) if streams else _records(level, level.where, radius_m, slot)
            words[records : records + made.size] = made.ravel()
            for page in level.pixels:
                column, row = layout.slot(slot)
                texels[row : row + SLOT, column : column + SLOT] = np.ascontiguousarray(page).view("<u4")[..., 0]
                slot += 1
            number += 1
    return texels


def stub_word(layout: ColorLayout, level: int, page: int) -> int:
    """The word that says where the record of a page of a level that streams is."""
    return int(layout.words[level, 1]) + _STUB * page + 2


def _stubs(level: ColorPages) -> Words:
    """(pages, _STUB) of which none is there."""
    return np.column_stack([level.where, np.full(len(level.where), -1)]).astype(np.int32)


def pool_record(level: ColorPages, page: int, radius_m: float, slot: int) -> Words:
    """(POOL_RECORD,) of a page that streams."""
    words, where = np.zeros(POOL_RECORD, np.int32), level.where[page]
    words[:_RECORD] = _records(level, where[None], radius_m, slot)[0]
    period = level.lattice.period
    columns = min(SIDE, period - int(where[1]) * SIDE) if period else SIDE
    words[_RECORD] = np.float32(1.0 / columns).view(np.int32)
    return words


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
    words[13] = int(isinstance(level, StreamedColorLevel))
    return words


def _hashed(level: ColorPages) -> NDArray[np.int64]:
    """Numbers of pages by the hash of their row and column, in the next place that is free."""
    size = _table_size(level)
    table = np.full(size, -1, np.int64)
    for number, at in enumerate(_hash(level.where).tolist()):
        place = at & (size - 1)
        while table[place] >= 0:
            place = (place + 1) & (size - 1)
        table[place] = number
    return table


def _table_size(level: ColorPages) -> int:
    size = 2
    while size < 2 * len(level.where):
        size *= 2
    return size


def _hash(where: NDArray[np.int64]) -> NDArray[np.uint32]:
    """As colors_hash() of the shader."""
    row, column = where.astype(np.uint32).T
    found = row * np.uint32(2654435761) ^ column * np.uint32(2246822519)
    found = (found ^ found >> np.uint32(15)) * np.uint32(2654435769)
    return found ^ found >> np.uint32(13)


def _records(level: ColorPages, where: NDArray[np.int64], radius_m: float, first_slot: int) -> Words:
    """(pages, _RECORD) of those at `where` (pages, 2). The pixel whose place is known is the page's middle, or the next
    one on this side of a pole."""
    lattice, count = level.lattice, len(where)
    row, column = (where * SIDE + SIDE // 2).T
    if not lattice.mercator:
        last = int(np.ceil(lattice.down - lattice.phase_y)) - 1
        row = np.clip(row, 0 if lattice.phase_y > 0.25 else 1, last)
    units = directions_at(*lattice.place(column, row)).T * (radius_m / fixed_unit_m(radius_m))
    whole = np.floor(units)
    words = np.zeros((count, _RECORD), np.int32)
    words[:, :2] = where
    words[:, 2] = first_slot + np.arange(count)
    words[:, 3], words[:, 4] = row - where[:, 0] * SIDE, column - where[:, 1] * SIDE
    words[:, 5:8] = whole
    words[:, 8:11] = np.ascontiguousarray((units - whole).astype(np.float32)).view(np.int32)
    return words


def write_anchor(table: NDArray[Any], point_m: NDArray[np.float64]) -> None:
    """Where the anchor (3,) of the height function's table is, in whole units and the rest."""
    unit_m = float(table["fixed_unit_m"])
    whole = np.floor(point_m / unit_m)
    table["real"]["place"], table["real"]["part"] = whole, point_m / unit_m - whole
