"""The icosphere (Lindner), with tiles chosen by measured error and edges that are closed exactly, at every morph."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from ....engine.gpu import GpuScope
from ....engine.graph import PassIO
from ....engine.surface.icosphere_anchor import TriangleAnchor
from ....engine.system import Frame
from ..tiles.shape import TileShape
from ..tiles.triangle import TriangleShape
from .base import Ground
from .tiled import TiledBackend, _TileView

__all__ = ["TRIANGLE_BINDING", "IcosphereBackend"]

TRIANGLE_BINDING = 9  # common/icosphere.glsl


class IcosphereBackend(TiledBackend):
    """Backend "icosphere"."""

    name: ClassVar[str] = "icosphere"

    def __init__(self, gpu: GpuScope, settings: Mapping[str, Any], method: str) -> None:
        super().__init__(gpu, settings, method)
        self._anchors: dict[int, tuple[tuple[int, float], Any]] = {}  # by view: what it was made for, and the block

    def make_shape(self, segments: int) -> TileShape:
        return TriangleShape(segments)

    def update(self, frame: Frame, ground: Ground, bind_octaves: Callable[[], None]) -> None:
        super().update(frame, ground, bind_octaves)
        proxy = frame.world.resource(f"proxy.{frame.view_index}")
        key = (proxy.generation, ground.params.radius_m)
        found, buffer = self._anchors.get(frame.view_index, ((), None))
        if found != key:
            block = TriangleAnchor(proxy.lattice.direction, ground.params.radius_m).block
            if buffer is None:
                buffer = self.gpu.buffer(reserve=len(block), dynamic=True)
            buffer.write(block)
            self._anchors[frame.view_index] = key, buffer

    def _bind_assemble(self, io: PassIO, view: _TileView) -> Callable[[], None]:
        assemble = super()._bind_assemble(io, view)
        index = next(n for n, v in self._views.items() if v is view)

        def run() -> None:
            self._anchors[index][1].bind_to_uniform_block(TRIANGLE_BINDING)
            assemble()

        return run
