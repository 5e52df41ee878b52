"""The ground's debug views: triangle edges, error of the drawn ground in pixels, holes. Culled unless somebody
looks."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...engine.frame import View
from ...engine.gpu import GpuScope
from ...engine.graph import GraphBuilder, PassIO, TextureSpec
from .backends import Backend
from .snap_overlay import SnapOverlay


class TerrainDebugPasses:
    """Declares ``debug.wireframe``, ``debug.error_px`` and ``debug.snap_overlay``. Programs are made when a view is
    looked at for the first time.

    gpu: the terrain's scope.
    """

    def __init__(self, gpu: GpuScope) -> None:
        self._gpu = gpu
        self._overlay = SnapOverlay(gpu)
        self._error: Any = None
        self._holes: Any = None

    def declare(self, builder: GraphBuilder, backend: Backend, view: View, bind_octaves: Callable[[], None]) -> None:
        """bind_octaves: binds the height function's table."""
        builder.add_pass(
            "terrain.wireframe",
            system="terrain",
            bind=lambda io: self._bind_wireframe(io, backend, view),
            reads=backend.draw_reads(view),
            creates=(TextureSpec("debug.wireframe", "rgba8"), TextureSpec("debug.wireframe_depth", "depth32f")),
            help="edges of all drawn triangles, coloured by level",
        )
        self._overlay.declare(builder, backend, view)
        builder.add_pass(
            "terrain.error_px",
            system="terrain",
            bind=lambda io: self._bind_error(io, bind_octaves),
            reads=("gbuffer.depth", "gbuffer.surface"),
            creates=(TextureSpec("debug.error_px", "r32f"),),
            help="distance of the drawn ground from the height function, in pixels",
        )
        builder.add_pass(
            "terrain.holes",
            system="terrain",
            bind=self._bind_holes,
            reads=("gbuffer.surface",),
            creates=(TextureSpec("debug.holes", "rgba8"),),
            help="background where there has to be ground",
        )

    def _bind_wireframe(self, io: PassIO, backend: Backend, view: View) -> Callable[[], None]:
        target = io.framebuffer(colors=("debug.wireframe",), depth="debug.wireframe_depth")
        solid = self._gpu.state(depth_test=True, depth_func=">=", cull="back", write_color=False)
        lines = self._gpu.state(depth_test=True, depth_func=">=", cull="back", wireframe=True)
        draw = backend.bind_draw(io, view, "terrain/wireframe.frag")

        def run() -> None:
            target.use()
            target.clear(0.02, 0.02, 0.03, 1.0, depth=0.0)
            solid.apply()
            draw()
            lines.apply()
            draw()

        return run

    def _bind_error(self, io: PassIO, bind_octaves: Callable[[], None]) -> Callable[[], None]:
        if self._error is None:
            self._error = self._gpu.fullscreen("terrain/error_px.frag")
        target = io.framebuffer(colors=("debug.error_px",))
        depth, surface = io.texture("gbuffer.depth"), io.texture("gbuffer.surface")
        state = self._gpu.state(depth_test=False)

        def run() -> None:
            target.use()
            state.apply()
            depth.use(0)
            surface.use(1)
            bind_octaves()
            self._error.render()

        return run

    def _bind_holes(self, io: PassIO) -> Callable[[], None]:
        if self._holes is None:
            self._holes = self._gpu.fullscreen("terrain/holes.frag")
        target, surface = io.framebuffer(colors=("debug.holes",)), io.texture("gbuffer.surface")
        state = self._gpu.state(depth_test=False)

        def run() -> None:
            target.use()
            state.apply()
            surface.use(0)
            self._holes.render()

        return run
