"""The cube's quadtree (Ralith, planetmap), with tiles chosen by measured error and edges that are closed exactly."""

from __future__ import annotations

from typing import ClassVar

from ..tiles.shape import QuadShape, TileShape
from .tiled import TiledBackend

__all__ = ["QuadtreeBackend"]


class QuadtreeBackend(TiledBackend):
    """Backend "quadtree"."""

    name: ClassVar[str] = "quadtree"

    def make_shape(self, segments: int) -> TileShape:
        return QuadShape(segments)
