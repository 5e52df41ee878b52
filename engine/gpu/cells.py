"""What is kept of each cell of a surface, as numpy and shaders have it: ``generated/cells.glsl``.

A file of its own structs for common/cells.glsl, with CELL_TILES those of tiles, whose vertices and boxes go by slots.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from ..blocks.layout import StructLayout, UInt, Vec3
from ..made_shaders import made_shader

__all__ = ["BOUNDS_BYTES", "CELL_DTYPE", "COMMAND_DTYPE", "TILE_CELL_DTYPE"]


@dataclass
class Cell:
    face: int
    level: int
    i: int
    j: int
    edge_mask: Annotated[UInt, "a byte an edge: along i-1, i+1, j-1, j+1 indices are rounded down by so many bits"]
    spacing_m: Annotated[float, "nominal distance of two vertices"]
    variant: Annotated[UInt, "index list: 2 ((CELL_MOST + 1) skip along i + skip along j) + (1: falling diagonals)"]
    distance_m: Annotated[float, "from the proxy to the nearest point of the cell"]


@dataclass
class TileCell:
    face: int
    level: int
    i: int
    j: int
    slot: UInt
    spacing_m: Annotated[float, "nominal distance of two vertices"]
    variant: Annotated[UInt, "0"]
    distance_m: Annotated[float, "from the proxy to the nearest point of the tile"]


@dataclass
class CellBounds:
    """A box around the vertices, from the anchor, planet axes, and their heights above the anchor's."""

    low_m: Vec3
    low_dh_m: float
    high_m: Vec3
    high_dh_m: float


@dataclass
class DrawCommand:
    """Of an indirect draw of indices, with moderngl's fixed stride."""

    count: UInt
    instances: UInt
    first_index: UInt
    base_vertex: int
    base_instance: UInt


_CELL, _TILE, _BOUNDS, _COMMAND = (StructLayout(c, "std430") for c in (Cell, TileCell, CellBounds, DrawCommand))
CELL_DTYPE, TILE_CELL_DTYPE, COMMAND_DTYPE = _CELL.dtype, _TILE.dtype, _COMMAND.dtype
BOUNDS_BYTES = _BOUNDS.size


def _shader() -> str:
    cell = f"#ifdef CELL_TILES\n{_TILE.glsl}#define Cell TileCell\n#else\n{_CELL.glsl}#endif\n"
    return f"{cell}{_BOUNDS.glsl}{_COMMAND.glsl}"


made_shader("generated/cells.glsl", _shader)
