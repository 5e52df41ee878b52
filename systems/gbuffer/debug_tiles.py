"""The debug view of the picture's tiles: which surfaces each shows. Culled unless somebody looks."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...engine.blocks.bindings import FLAG_BUFFER
from ...engine.gpu import GpuScope
from ...engine.graph import GraphBuilder, PassIO, TextureSpec

__all__ = ["TilesPicture"]


class TilesPicture:
    """Declares ``debug.tiles``; its program is made when it is first looked at. gpu: the system's scope."""

    def __init__(self, gpu: GpuScope) -> None:
        self._gpu = gpu
        self._draw: Any = None
        self._plain = gpu.state()

    def declare(self, builder: GraphBuilder, across: int) -> None:
        """across: tiles in a row of the picture."""
        builder.add_pass(
            "gbuffer.debug_tiles",
            bind=lambda io: self._bind(io, across),
            system="gbuffer",
            reads=("gbuffer.tile_flags",),
            creates=(TextureSpec("debug.tiles", "rgba8", help="green ground, blue sea, orange both, pink props"),),
            help="which surfaces each tile of the picture shows",
        )

    def _bind(self, io: PassIO, across: int) -> Callable[[], None]:
        if self._draw is None:
            self._draw = self._gpu.fullscreen("gbuffer/debug_tiles.frag")
        target, flags = io.framebuffer(colors=("debug.tiles",)), io.buffer("gbuffer.tile_flags")

        def run() -> None:
            target.use()
            self._plain.apply()
            flags.bind_to_storage_buffer(FLAG_BUFFER)
            self._draw.set("u_across", across)
            self._draw.render()

        return run
