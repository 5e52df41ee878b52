"""The GPU's copy of real ground: one texture of words, laid out as assets/shaders/terrain/real_ground.glsl reads it.

Slots of pages come first, side by side: heights of all levels, then weights. Words follow, counted row by row from the
texture's beginning: of each level the table of blocks, the pages of each block, and a record a page:

    0, 1  slots of its heights and of its weights, -1: all are 1
    2     row of the page's first own sample
    3-    height differences of its samples at ROUGH x ROUGH nodes, float
    124-  of each square of samples, row by row, 8 words about the sample in its middle: whole parts of its place in the
          height function's units (3), what is left of them (3, float), its row and its column in the page

A place is counted from the sample that is nearest of these: float then knows it to 2e-6 of a sample, or 4e-7.

Of levels that stream (real_stream.py) slots, records and what the table says of pages change as they come and go. Their
slots are those after all others; records of all of them follow those of the last level, POOL_RECORD words each, with
one more number after the squares, one over the page's own columns. What they weigh at their corners, north-west,
north-east, south-west and south-east, comes last, four numbers a record.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from ...engine.blocks.layout import IVec2, IVec3, Vec2, Vec3, Vec4
from ...engine.made_shaders import made_shader
from ...engine.real_ground.lattice import directions_at
from ...engine.real_ground.pages import BEFORE, PAGE, ROUGH, ROUGH_SIDE, SLOT, TABLE, PageLevel
from ...engine.real_ground.real_ground import DONE, LEVEL_SAMPLES, MOST_ROUGH, RealGround
from ...engine.real_ground.resident import MOST_LEVELS
from ...engine.real_ground.streamed_ground import StreamedGround
from ...engine.real_ground.streamed_level import StreamedLevel

__all__ = [
    "HEIGHTS_FINER",
    "MOST_LEVELS",
    "POOL_RECORD",
    "RealLayout",
    "TerrainReal",
    "TerrainRealLevel",
    "fixed_unit_m",
    "pool_record",
    "real_layout",
    "real_texels",
    "write_real",
]

_PLACE, _FIRST_NODE = 8, 3
_FIRST_SQUARE = _FIRST_NODE + ROUGH * ROUGH
_NEAR, _NEARER, _FEW_PAGES = 15, 3, 64
"""Samples a side of squares; of levels of few pages, which are coarse and where heights change more from one sample to
the next."""
_SLOT_BITS = SLOT.bit_length() - 1
POOL_RECORD = 1024
"""Words of a record of a level that streams: a power of two, so that none crosses rows of the texture."""
_AFTER_SQUARES = _FIRST_SQUARE + (PAGE // _NEAR) ** 2 * _PLACE
HEIGHTS_FINER = 0.5
"""Heights show as much of a level that streams as gradients do where vertices are so many times as far apart: what they
leave out is less than a pixel high."""
_POOL_BYTES = 4 * (SLOT * SLOT + POOL_RECORD + 4)
_FEWEST = 32
_MOST_ROWS = 16384


@dataclass
class TerrainReal:
    """Tiles of elevation around the anchor."""

    place: Annotated[IVec3, "of the anchor, whole fixed units"]
    levels: Annotated[int, "0: there are no tiles"]
    part: Annotated[Vec3, "of a unit beyond that"]
    width_bits: Annotated[int, "of the texture's rows"]
    rough: Annotated[int, "whether relief goes on below samples"]
    ground_m: Annotated[float, "what heights count from"]
    ground_rest_m: Annotated[float, "and what float leaves of it"]
    first_fade: Annotated[int, "word of what pages that stream weigh at their corners"]


@dataclass
class TerrainRealLevel:
    across: Annotated[float, "columns around the world"]
    down: Annotated[float, "rows from pole to pole"]
    phase: Vec2
    per_rad: Annotated[Vec2, "columns and rows by an angle"]
    sample_m: float
    finest_m: Annotated[float, "the same of the finest level of its set"]
    rough_per_m: Annotated[float, "roughness of the relief below its samples, by their height differences"]
    octaves: Annotated[float, "to the next level of its set; 0: there is none"]
    first_column: float
    mercator: int
    page_columns: Annotated[int, "around the world; 0: they never meet again"]
    first_word: Annotated[int, "of the table of blocks"]
    first_page: Annotated[int, "word of the blocks' pages"]
    first_record: Annotated[int, "word of the pages' records"]
    record: Annotated[int, "words of one"]
    near: Annotated[int, "samples a side of its squares"]
    streamed: Annotated[int, "whether its pages come and go"]
    first_block: Annotated[IVec2, "column and row"]
    blocks: Annotated[IVec2, "columns and rows"]
    polar: Annotated[Vec4, "height and weight at the north pole and at the south pole"]


def _shader() -> str:
    numbers: dict[str, Any] = {
        "PAGE": PAGE, "BEFORE": BEFORE, "SLOT_BITS": _SLOT_BITS, "TABLE": TABLE, "PLACE": _PLACE,
        "FIRST_SQUARE": _FIRST_SQUARE, "FIRST_NODE": _FIRST_NODE, "ROUGH": ROUGH, "ROUGH_SIDE": float(ROUGH_SIDE),
        "POOL_RECORD": POOL_RECORD, "AFTER_SQUARES": _AFTER_SQUARES, "LEVEL_SAMPLES": LEVEL_SAMPLES, "DONE": DONE,
        "MOST_ROUGH": MOST_ROUGH, "HEIGHTS_FINER": HEIGHTS_FINER, "PI": 3.14159265358979,
    }  # fmt: skip
    return "".join(f"const {type(v).__name__} REAL_{name} = {v};\n" for name, v in numbers.items())


made_shader("generated/terrain_real_numbers.glsl", _shader)


@dataclass(frozen=True)
class RealLayout:
    """width_bits of the texture; of each level the words where its table, pages and records begin; the first of all
    these, and one after the last. pool: slots of pages that come and go, the first of which is first_slot; first_fade:
    the word of what they weigh."""

    width_bits: int
    words: NDArray[np.int64]
    first: int
    end: int
    first_slot: int
    pool: int
    first_fade: int

    def slot(self, slot: int) -> tuple[int, int]:
        """Column and row of the slot's first texel."""
        across = 1 << (self.width_bits - _SLOT_BITS)
        return slot % across * SLOT, slot // across * SLOT

    def place(self, word: int) -> tuple[int, int]:
        """Column and row of a word."""
        return word & ((1 << self.width_bits) - 1), word >> self.width_bits


def fixed_unit_m(radius_m: float) -> float:
    """Of places in fixed point: a power of two, of which the radius has 2^22 to 2^23."""
    return float(2.0 ** (np.floor(np.log2(radius_m)) - 22))


def real_layout(found: RealGround) -> RealLayout:
    """Where in the texture what is."""
    first_slot = sum(len(level.heights) + len(level.weights) for level in found.levels)
    pool = 0
    if isinstance(found, StreamedGround):
        left = found.budget_bytes - sum(level.nbytes for level in found.levels)
        pool = max(left // _POOL_BYTES, _FEWEST)
    slots = first_slot + pool
    bits = _SLOT_BITS + 5
    while bits < 14 and -(-slots >> (bits - _SLOT_BITS)) * SLOT > _MOST_ROWS // 2:
        bits += 1
    words = np.zeros((len(found.levels), 3), np.int64)
    first = at = -(-slots >> (bits - _SLOT_BITS)) * SLOT << bits
    for number, level in enumerate(found.levels):
        _, _, blocks, pages = level.table
        records = 0 if isinstance(level, StreamedLevel) else len(level.where) * _record(_near(level))
        for k, size in enumerate((blocks.size, pages.size, records)):
            words[number, k] = at
            at += size
    fade = at
    if pool:
        at = -(-at >> bits) << bits
        words[[isinstance(level, StreamedLevel) for level in found.levels], 2] = at
        fade = -(-(at + pool * POOL_RECORD) >> bits) << bits
        at = fade + 4 * pool
    return RealLayout(bits, words, first, at, first_slot, pool, fade)


def real_texels(found: RealGround, unit_m: float, radius_m: float) -> NDArray[np.uint32]:
    """Texels (rows, columns) of words, without any page that streams. unit_m: of places in fixed point."""
    layout = real_layout(found)
    width = 1 << layout.width_bits
    texels = np.zeros((-(-layout.end // width), width), np.uint32)
    flat, at = texels.reshape(-1), layout.first
    heights, weights = 0, sum(len(level.heights) for level in found.levels)
    for level in found.levels:
        _, _, blocks, pages = level.table
        parts = [blocks, np.full_like(pages, -1)]
        if not isinstance(level, StreamedLevel):
            parts = [blocks, pages, _records(level, unit_m, radius_m, heights, weights)]
        heights, weights = heights + len(level.heights), weights + len(level.weights)
        for part in parts:
            flat[at : at + part.size] = part.astype(np.int32).ravel().view(np.uint32)
            at += part.size
    slot = 0
    for kind in ("heights", "weights"):
        for level in found.levels:
            for page in getattr(level, kind):
                column, row = layout.slot(slot)
                texels[row : row + SLOT, column : column + SLOT] = page.view(np.uint32)
                slot += 1
    return texels


def _records(level: PageLevel, unit_m: float, radius_m: float, heights: int, weights: int) -> NDArray[np.int32]:
    """(pages, words). heights, weights: the level's first slots."""
    count, near = len(level.where), _near(level)
    found = np.zeros((count, _record(near)), np.int32)
    found[:, 0] = heights + np.arange(count)
    found[:, 1] = np.where(level.of_weights >= 0, weights + level.of_weights, -1)
    found[:, 2] = level.where[:, 0] * PAGE
    found[:, _FIRST_NODE:_FIRST_SQUARE] = level.roughness.reshape(count, -1).view(np.int32)
    found[:, _FIRST_SQUARE:] = _places(level, level.where, unit_m, radius_m, near).reshape(count, -1)
    return found


def pool_record(
    level: PageLevel, page: int, roughness: NDArray[np.float32], slots: tuple[int, int], unit_m: float, radius_m: float
) -> NDArray[np.int32]:
    """(POOL_RECORD,) of a page that streams. slots: of its heights and of its weights."""
    found, where = np.zeros(POOL_RECORD, np.int32), level.where[page]
    found[0], found[1], found[2] = *slots, where[0] * PAGE
    found[_FIRST_NODE:_FIRST_SQUARE] = roughness.ravel().view(np.int32)
    found[_FIRST_SQUARE:_AFTER_SQUARES] = _places(level, where[None], unit_m, radius_m, _NEAR).ravel()
    period = level.lattice.period
    columns = min(PAGE, period - int(where[1]) * PAGE) if period else PAGE
    found[_AFTER_SQUARES] = np.float32(1.0 / columns).view(np.int32)
    return found


def _near(level: PageLevel) -> int:
    if isinstance(level, StreamedLevel):
        return _NEAR
    return _NEARER if len(level.where) <= _FEW_PAGES else _NEAR


def _record(near: int) -> int:
    return _FIRST_SQUARE + (PAGE // near) ** 2 * _PLACE


def _places(level: PageLevel, where: NDArray[np.int64], unit_m: float, radius_m: float, near: int) -> NDArray[np.int32]:
    """(pages, K, PLACE) of samples in the middle of K squares of pages at `where`. Directions about them have to be
    plain, so those beyond a pole make way for others on this side of it."""
    at = near * np.arange(PAGE // near) + near // 2
    columns, rows = (v.ravel() for v in np.meshgrid(at, at))
    lattice, first = level.lattice, where * PAGE
    row, column = first[:, :1] + rows, first[:, 1:] + columns
    if not lattice.mercator:
        last = int(np.ceil(lattice.down - lattice.phase_y)) - 1
        row = np.clip(row, 0 if lattice.phase_y > 0.25 else 1, last)
    latitude, longitude = lattice.place(column, row)
    units = np.moveaxis(directions_at(latitude, longitude), 0, -1) * (radius_m / unit_m)
    whole = np.floor(units)
    found = np.zeros((*row.shape, _PLACE), np.int32)
    found[..., 0:3] = whole
    found[..., 3:6] = np.ascontiguousarray((units - whole).astype(np.float32)).view(np.int32)
    found[..., 6], found[..., 7] = row - first[:, :1], column - first[:, 1:]
    return found


def write_real(
    table: NDArray[Any],
    found: RealGround,
    rough_by: Sequence[float] | None,
    point_m: NDArray[np.float64],
    height_m: float,
) -> None:
    """The tiles' part of the height function's table around a point (3,), where heights count from height_m. rough_by:
    as Model.real_rough."""
    unit_m, radius_m = float(table["fixed_unit_m"]), float(table["radius_m"])
    layout = real_layout(found)
    real, whole = table["real"], np.floor(point_m / unit_m)
    real["place"], real["part"] = whole, point_m / unit_m - whole
    real["levels"], real["width_bits"] = len(found.levels), layout.width_bits
    real["rough"] = int(rough_by is not None)
    real["first_fade"] = layout.first_fade
    real["ground_m"] = height_m
    real["ground_rest_m"] = height_m - float(real["ground_m"])
    for number, (level, factor) in enumerate(zip(found.levels, found.factors, strict=True)):
        row, lattice = table["real_levels"][number], level.lattice
        first_row, first_column, blocks, _ = level.table
        row["across"], row["down"], row["phase"] = lattice.across, lattice.down, (lattice.phase_x, lattice.phase_y)
        by_angle = lattice.down / (2.0 * np.pi if lattice.mercator else np.pi)
        row["per_rad"] = lattice.across / (2.0 * np.pi), by_angle
        row["sample_m"] = lattice.sample_m(radius_m)
        row["finest_m"] = found.levels[found.finest_of[number]].lattice.sample_m(radius_m)
        row["rough_per_m"] = 0.0 if rough_by is None else rough_by[number]
        row["octaves"] = np.log2(factor) if factor else 0.0
        row["first_column"], row["mercator"] = level.first_column, int(lattice.mercator)
        row["page_columns"] = -(-lattice.period // PAGE)
        row["first_word"], row["first_page"], row["first_record"] = layout.words[number]
        row["near"] = _near(level)
        streams = isinstance(level, StreamedLevel)
        row["record"] = POOL_RECORD if streams else _record(_near(level))
        row["streamed"] = int(streams)
        row["first_block"], row["blocks"] = (first_column, first_row), blocks.shape[::-1]
        row["polar"] = level.polar.ravel()
