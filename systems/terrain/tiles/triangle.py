"""TriangleShape: the icosphere's tiles; the twin of assets/shaders/terrain/tiles/triangle.glsl."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ....engine.surface.icosphere import FULL_BITS, TriangleScheme
from ....engine.surface.triangle_patch import patch_indices, vertex_count, vertex_place
from .shape import TileShape
from .slots import tile_names

__all__ = ["TriangleShape"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class TriangleShape(TileShape):
    """Triangular tiles of `segments` a side; vertices as in engine.surface.triangle_patch."""

    def __init__(self, segments: int) -> None:
        self.scheme = self._triangles = TriangleScheme()
        self.segments = segments
        self.vertices = vertex_count(segments)
        self.table_pairs = 1  # a tile's name says all; buffers may not be empty
        bits = segments.bit_length() - 1
        self.defines = {"TILE_LOG2": bits, "QUADS_LOG2": bits, "CELL_TILES": 1, "CELL_TRIANGLES": 1}
        self.indices = patch_indices(segments).ravel()

    def names(self, keys: Ints) -> NDArray[np.void]:
        return tile_names(self.scheme.unpack(keys))

    def tables(self, keys: Ints) -> Floats:
        return np.zeros((len(keys), 1))

    def points(self, keys: Ints) -> tuple[Ints, Ints, Ints]:
        root, b, c = self._triangles.corner_points(keys)
        step = (np.int64(1) << FULL_BITS - self.scheme.level(keys)) // self.segments * np.sign(b[:, 1] - b[:, 0])
        p, q = vertex_place(np.arange(self.vertices), self.segments)
        points_b, points_c = b[:, :1] + p * step[:, None], c[:, :1] + q * step[:, None]
        return np.broadcast_to(root[:, None], points_b.shape), points_b, points_c
