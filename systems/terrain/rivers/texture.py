"""The GPU's copy of a planet's rivers: one texture of integers, laid out as assets/shaders/terrain/rivers.glsl says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ....engine.made_shaders import made_shader
from . import form
from .banks import BANK_OFFSETS
from .table import BEND_CELLS, CELL_STEPS, RiverTable

__all__ = ["RiverLayout", "river_layout", "river_texels"]

Integers = NDArray[np.int32]

_WIDTH_BITS = 12
_COUNT_BITS, _MORE_BITS = 6, 9
"""Of the number of lines in a cell; where they are given, they are fewer in all and more in a cell."""
_NODE_BITS = 22
"""Of a node's number; those above hold the half width of the line that begins there, in 24ths of octaves from 1/64 m to
40 km."""
_WIDTH_STEPS, _WIDTH_LEAST = 24, -6
_WIDEST_BIT = 21
"""Of a column, from which on it has that of its widest line."""
_BLOCK = 8
"""Columns a side of a block, of whose widest line the code is kept, too: for tiles of the picture that show many."""


@dataclass(frozen=True)
class RiverLayout:
    """Where the parts lie in the texture, in texels."""

    across: int
    """columns of cells along x and along y"""
    first_cell: int
    first_line: int
    first_node: int
    first_block: int
    count_bits: int


_LAYOUTS: WeakKeyDictionary[RiverTable, RiverLayout] = WeakKeyDictionary()
"""The layouts alone are kept: Earth's texels have 45 MB, and are made again in a tenth of a second."""


def river_texels(table: RiverTable) -> tuple[RiverLayout, Integers]:
    """(layout, texels (rows, 4096, 4) int32)."""
    many, bits = np.diff(table.begin), _MORE_BITS if table.given else _COUNT_BITS
    if len(many) and int(many.max()) >= 1 << bits:
        raise ValueError(f"rivers: {int(many.max())} lines pass one cell; at most {(1 << bits) - 1} can")
    across = 2 * (int(np.ceil(table.radius_m / table.cell_m)) + 1)
    packed = _packed_lines(table)
    widest = np.zeros(len(many), dtype=np.int32)  # the first of each cell's
    widest[many > 0] = packed[table.begin[:-1][many > 0]] >> _NODE_BITS
    columns, cells = _columns(table, across, (table.begin[:-1] << bits) | many, widest)
    blocks = _blocks(columns, across)
    line_rows, node_rows = -(-max(len(table.lines), 1) // 4), 3 * len(table.place)
    rows = (columns.size // 4, cells.size // 4, line_rows, node_rows, blocks.size // 4)
    ends = np.cumsum(rows).tolist()
    width = 1 << _WIDTH_BITS
    texels = np.zeros((-(-ends[-1] // width) * width, 4), dtype=np.int32)
    # Each part where it belongs: they are too large to be copied.
    columns_at, cells_at, lines_at, nodes_at, blocks_at = np.split(texels[: ends[-1]], ends[:-1])
    columns_at[:], cells_at[:], blocks_at[:] = columns.reshape(-1, 4), cells.reshape(-1, 4), blocks.reshape(-1, 4)
    lines_at.reshape(-1)[: len(packed)] = packed
    nodes = nodes_at.reshape(-1, 3, 4)
    nodes[:, 0, :3], nodes[:, 0, 3] = table.place, table.to
    nodes[:, 1:] = table.values.view(np.int32).reshape(-1, 2, 4)
    first_cell, first_line, first_node, first_block = ends[:-1]
    layout = _LAYOUTS[table] = RiverLayout(across, first_cell, first_line, first_node, first_block, bits)
    return layout, texels.reshape(-1, width, 4)


def _packed_lines(table: RiverTable) -> Integers:
    """Lines of cells, and in the high bits the logarithm of their half widths, rounded up; 0: dry."""
    if len(table.place) >= 1 << _NODE_BITS:
        raise ValueError(f"rivers: {len(table.place)} nodes; at most {(1 << _NODE_BITS) - 1} can be")
    half_width = table.half_width_m
    code = np.ceil((np.log2(np.maximum(half_width, 1e-9)) - _WIDTH_LEAST) * _WIDTH_STEPS)
    code = np.where(half_width > 0.0, np.clip(code, 1, (1 << 31 - _NODE_BITS) - 1), 0).astype(np.int32)
    return table.lines | code[table.lines] << _NODE_BITS


def river_layout(table: RiverTable) -> RiverLayout:
    """The layout alone."""
    return _LAYOUTS.get(table) or river_texels(table)[0]


def _columns(table: RiverTable, across: int, packed: Integers, widest: Integers) -> tuple[Integers, Integers]:
    """Columns (2 across^2, 2): index of the lowest cell; and the code of the widest line's half width, the end of its
    cells' z and their lowest z, both from -512 on, in bits from 21, 10 and 0. Cells (K,) of all columns, 0 where no
    line passes. South of the equator first. packed, widest: of the table's cells."""
    keys = table.keys.astype(np.int32)
    x, y, z = keys & 1023, keys >> 10 & 1023, keys >> 20
    number = ((z >= 512) * across + (y - 512 + across // 2)) * across + (x - 512 + across // 2)
    number = number.astype(np.intp)
    low, high, wide = np.zeros((3, 2 * across * across), dtype=np.int32)
    low[:] = 1023
    low[number[::-1]] = z[::-1]  # keys rise with z, and of equal places the last is written
    high[number] = z + 1
    np.maximum.at(wide, number, widest)
    tall = np.maximum(high - low, 0)
    last = np.cumsum(tall, dtype=np.int32)
    cells = np.zeros(-(-max(int(last[-1]), 1) // 4) * 4, dtype=np.int32)
    first = last - tall
    cells[(first - low)[number] + z] = packed
    columns = np.stack([first, (wide << _WIDEST_BIT) | (high << 10) | low], axis=1)
    return np.concatenate([columns, np.zeros((len(columns) % 2, 2), np.int32)]), cells


def _blocks(columns: Integers, across: int) -> Integers:
    """Codes of the widest lines in blocks of columns, south of the equator first, row by row."""
    side = -(-across // _BLOCK)
    wide = np.zeros((2, side * _BLOCK, side * _BLOCK), dtype=np.int32)
    wide[:, :across, :across] = (columns[: 2 * across * across, 1] >> _WIDEST_BIT).reshape(2, across, across)
    found = wide.reshape(2, side, _BLOCK, side, _BLOCK).max(axis=(2, 4)).ravel()
    return np.concatenate([found, np.zeros(-len(found) % 4, np.int32)])


def _shader() -> str:
    numbers: dict[str, Any] = {
        "TEXTURE_WIDTH": 1 << _WIDTH_BITS, "TEXTURE_BITS": _WIDTH_BITS, "HALF": 512, "WIDEST_BIT": _WIDEST_BIT,
        "BLOCK": _BLOCK, "NODE_BITS": _NODE_BITS, "WIDTH_STEPS": float(_WIDTH_STEPS),
        "WIDTH_LEAST": float(_WIDTH_LEAST), "CELL_BITS": CELL_STEPS.bit_length() - 1, "BENDS": len(BEND_CELLS),
        "BANK_SHARE": form.BANK_SHARE, "FLOOR_SLOPE": form.FLOOR_SLOPE,
        "BANK_FAR": form.BANK_FAR, "BANK_OUT": form.BANK_OUT,
    }  # fmt: skip
    numbers |= {f"BANK_OFFSET_{k}": offset for k, offset in enumerate(BANK_OFFSETS)}
    text = "".join(f"const {type(v).__name__} RIVER_{name} = {v};\n" for name, v in numbers.items())
    return text + form.shader()


made_shader("generated/terrain_river_form.glsl", _shader)
