"""The cube's quadtree as the article "Planetary Terrain" has it (Ralith, planetmap): Terrain.method "paper".

Chunks are split by distance; the parent is drawn until all four children are there; they change places at once. Places
are interpolated between four corners from float64, the sphere's bulge comes by the law of sines, the low bits of a
vertex's place are masked by how much coarser the neighbour is. Heights are ours.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from ....engine.blocks.layout import StructLayout, Vec3
from ....engine.frame import Frame, Views
from ....engine.gpu import GpuScope
from ....engine.graph import PassIO
from ....engine.made_shaders import made_shader
from ....engine.settings import Settings
from ....engine.surface.forest import Forest
from ..tiles.shape import QuadShape, TileShape
from .base import Ground
from .tile_view import SplitBy, TileView
from .tiled import TiledBackend

__all__ = ["PaperQuadtreeBackend"]


@dataclass
class ChunkCorner:
    foot_m: Annotated[Vec3, "from the anchor's foot, planet axes"]
    normal: Vec3


_CORNER = StructLayout(ChunkCorner, "std430")
made_shader("generated/chunk_corner.glsl", lambda: _CORNER.glsl)


class PaperQuadtreeBackend(TiledBackend):
    """Backend "quadtree", method "paper"."""

    name: ClassVar[str] = "quadtree"
    assemble_file: ClassVar[str] = "terrain/tiles/paper/quad.comp"
    morphs: ClassVar[bool] = False

    def __init__(self, gpu: GpuScope, settings: Settings, views: Views) -> None:
        super().__init__(gpu, settings, views)
        self._corners = gpu.buffer(reserve=self._slots * 4 * _CORNER.size, dynamic=True)

    def make_shape(self, segments: int) -> TileShape:
        return QuadShape(segments)

    def split_by(self, frame: Frame) -> SplitBy:
        return SplitBy(frame.pixel_rad, float(frame.settings["terrain.edge_px"]))

    def make_forest(self, ground: Ground, occluder_m: float, frame: Frame) -> Forest:
        pixel_rad, edge_px = self.split_by(frame)
        params, scheme = ground.params, self.shape.scheme
        levels = np.arange(scheme.finest_level + 1)
        spacing_m = params.radius_m * scheme.spacing_rad(levels, self.shape.segments)
        return Forest(
            scheme,
            params.radius_m,
            params.lowest_m,
            params.highest_m,
            self.shape.segments,
            occluder_m=occluder_m,
            metric="distance",
            split_distance_m=spacing_m / (edge_px * pixel_rad),
            balanced=False,
        )

    def _bind_assemble(self, io: PassIO, view: TileView) -> Callable[[], None]:
        assemble = super()._bind_assemble(io, view)

        def run() -> None:
            if view.mesh.count:
                normals = self.shape.scheme.corners(view.mesh.keys)
                corners = np.zeros((view.mesh.count, 4), _CORNER.dtype)
                corners["foot_m"] = self._radius_m * (normals - view.of.proxy.lattice.direction)
                corners["normal"] = normals
                self._corners.write(corners.tobytes())
            self._corners.bind_to_storage_buffer(4)
            assemble()

        return run
