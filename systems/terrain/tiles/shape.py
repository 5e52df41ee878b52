"""TileShape: what a scheme's tiles are to the GPU; the twin of assets/shaders/terrain/tiles/<scheme>.glsl."""

from __future__ import annotations

from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from ....engine.surface.lattice import FULL, FULL_BITS, angle_tangent
from ....engine.surface.scheme import QuadScheme, Scheme
from .slots import tile_names

__all__ = ["QuadShape", "TileShape"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class TileShape(Protocol):
    """Vertices and triangles of the tiles of one scheme with `segments` a side.

    scheme: engine.surface.scheme. vertices: of a tile. indices: (3 T,) u4, counter-clockwise seen from outside, the
    same for all tiles. table_pairs: numbers that the shader wants of each tile, as pairs of floats. defines: for all of
    its programs.
    """

    scheme: Scheme
    segments: int
    vertices: int
    indices: NDArray[np.uint32]
    table_pairs: int
    defines: dict[str, int]

    def names(self, keys: Ints) -> NDArray[np.void]:
        """(N,) TileName."""
        ...

    def tables(self, keys: Ints) -> Floats:
        """(N, table_pairs)."""
        ...

    def points(self, keys: Ints) -> tuple[NDArray[np.int64], ...]:
        """The lattice points of all vertices, as arrays (N, vertices) that the scheme's direction_of takes."""
        ...


class QuadShape(TileShape):
    """Tiles of the cube's quadtree: vertex b (segments + 1) + a, a along i."""

    edges: ClassVar[int] = 4

    def __init__(self, segments: int) -> None:
        self.scheme = QuadScheme()
        self.segments = segments
        self.side = segments + 1
        self.vertices = self.side**2
        self.table_pairs = 2 * self.side
        bits = segments.bit_length() - 1
        self.defines = {"TILE_LOG2": bits, "QUADS_LOG2": bits, "CELL_TILES": 1}
        j, i = np.mgrid[0:segments, 0:segments].reshape(2, -1)
        a = j * self.side + i
        b, c, d = a + 1, a + self.side, a + self.side + 1
        self.indices = np.stack([a, b, d, a, d, c], axis=1).astype(np.uint32).ravel()

    def names(self, keys: Ints) -> NDArray[np.void]:
        return tile_names(self.scheme.unpack(keys))

    def _steps(self, keys: Ints) -> tuple[Ints, Ints, Ints]:
        face, level, i, j = self.scheme.unpack(keys)
        size = np.int64(1) << (FULL_BITS - level)
        along = np.arange(self.side) * (size // self.segments)[:, None]
        return face, (i * size)[:, None] + along, (j * size)[:, None] + along

    def tables(self, keys: Ints) -> Floats:
        _, columns, rows = self._steps(keys)
        return angle_tangent(np.concatenate([columns, rows], axis=1), FULL)

    def points(self, keys: Ints) -> tuple[Ints, Ints, Ints]:
        face, columns, rows = self._steps(keys)
        count = len(face)
        shape = (count, self.side, self.side)
        i = np.broadcast_to(columns[:, None, :], shape).reshape(count, -1)
        j = np.broadcast_to(rows[:, :, None], shape).reshape(count, -1)
        return np.broadcast_to(face[:, None], i.shape), i, j
