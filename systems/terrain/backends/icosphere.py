"""The icosphere (Lindner), with tiles chosen by measured error and edges that are closed exactly, at every morph."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from ....engine.blocks.bindings import TRIANGLE_BLOCK
from ....engine.frame import Frame
from ....engine.graph import PassIO
from ....engine.surface.icosphere_anchor import AnchorKey, TriangleAnchor
from ..tiles.shape import TileShape
from ..tiles.triangle import TriangleShape
from .tile_view import TileView
from .tiled import TiledBackend

__all__ = ["IcosphereBackend"]


class IcosphereBackend(TiledBackend):
    """Backend "icosphere"."""

    name: ClassVar[str] = "icosphere"

    def make_shape(self, segments: int) -> TileShape:
        return TriangleShape(segments)

    def update(self, frame: Frame) -> None:
        super().update(frame)
        proxy = frame.view.proxy
        radius_m = self.ground.params.radius_m
        key = AnchorKey(proxy.generation, radius_m)
        view = self.view(frame.view)
        if view.anchor_key != key:
            block = TriangleAnchor(proxy.lattice.direction, radius_m).block
            if view.anchor is None:
                view.anchor = view.gpu.buffer(reserve=len(block), dynamic=True)
            view.anchor.write(block)
            view.anchor_key = key

    def _bind_assemble(self, io: PassIO, view: TileView) -> Callable[[], None]:
        assemble = super()._bind_assemble(io, view)

        def run() -> None:
            view.anchor.bind_to_uniform_block(TRIANGLE_BLOCK)
            assemble()

        return run
