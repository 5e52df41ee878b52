"""What the GPU keeps of tiles, as numpy and shaders have it: ``generated/tile_slots.glsl``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from ....engine.blocks.layout import StructLayout, UInt, Vec4
from ....engine.made_shaders import made_shader

__all__ = ["FACTS_DTYPE", "NAME_DTYPE", "REQUEST_DTYPE", "ROW_DTYPE", "VERTEX_BYTES", "tile_names"]


@dataclass
class TileName:
    """As the scheme has it. Of triangles i is the column and j = 2 row + orientation."""

    root: int
    level: int
    i: int
    j: int


@dataclass
class TileVertex:
    """What a slot keeps of each vertex. Heights are integers, so that a difference from an anchor's is exact."""

    height: Annotated[int, "above the reference sphere, in steps of u_step_m"]
    normal: Annotated[UInt, "octahedral, 2 x snorm16, planet axes"]
    attributes: Annotated[UInt, "terrain/attributes.glsl"]


@dataclass
class TileFacts:
    low: Annotated[int, "of the vertices, in steps"]
    high: Annotated[int, "in steps"]
    error_m: Annotated[float, "largest distance of the true ground, where it was looked at, from the tile's triangles"]


@dataclass
class TileRequest:
    """A tile to be made."""

    name: TileName
    slot: UInt
    table: Annotated[UInt, "its first pair in the table of numbers that the scheme wants from the CPU"]
    spacing_m: float


@dataclass
class TileRow:
    """A tile to be drawn, in the order of the selection."""

    name: TileName
    slot: UInt
    edge_skip: Annotated[UInt, "a byte an edge: vertices along it are rounded down to multiples of 2^skip"]
    morph: Annotated[float, "0 as it is, 1 as its parent"]
    spacing_m: float
    edge_morph: Annotated[Vec4, "by edge"]


_NAME, _VERTEX, _FACTS, _REQUEST, _ROW = (
    StructLayout(kept, "std430") for kept in (TileName, TileVertex, TileFacts, TileRequest, TileRow)
)
NAME_DTYPE, FACTS_DTYPE, REQUEST_DTYPE, ROW_DTYPE = (kept.dtype for kept in (_NAME, _FACTS, _REQUEST, _ROW))
VERTEX_BYTES = _VERTEX.size

made_shader("generated/tile_slots.glsl", lambda: "".join(kept.glsl for kept in (_ROW, _VERTEX, _FACTS, _REQUEST)))


def tile_names(parts: tuple[NDArray[np.int64], ...]) -> NDArray[np.void]:
    """Records of TileName from arrays (N,) of root, level, i and j."""
    names = np.empty(len(parts[0]), NAME_DTYPE)
    for field, part in zip(("root", "level", "i", "j"), parts, strict=True):
        names[field] = part
    return names
