"""GBufferSystem: clears the G-buffer, turns it into the renderer's output arrays, and presents the finished picture.

The output passes run only while somebody asks for their arrays: the graph culls them otherwise.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...engine.blocks.bindings import FLAG_BUFFER, SEA_TILES_BUFFER, TERRAIN_TILES_BUFFER
from ...engine.frame import View, ViewInfo
from ...engine.frame.gbuffer import ATTACHMENTS, GBUFFER, tiles_of
from ...engine.graph import BufferSpec, GraphBuilder, PassIO, TextureSpec
from ...engine.system import Setup, System
from .debug_tiles import TilesPicture
from .labels import LabelPasses


class GBufferSystem(System):
    """Owns gbuffer.*, the lists of tiles by surface, outputs.* and the passes that fill the imports ``target`` and
    ``target_with_depth``, a host's framebuffers."""

    name = "gbuffer"

    def setup(self, setup: Setup) -> None:
        self._gpu = setup.gpu
        self._classify = setup.gpu.compute("gbuffer/classify.comp")
        self._list = setup.gpu.compute("gbuffer/list_tiles.comp")
        self._tiles_picture = TilesPicture(setup.gpu)
        self._labels = LabelPasses(setup.gpu, setup.world)
        self._geometry = setup.gpu.fullscreen("outputs/geometry.frag")
        self._present = setup.gpu.fullscreen("outputs/present.frag")
        self._present_scaled: Any = None
        self._present_depth: Any = None
        self._write_all = setup.gpu.state(depth_test=False, cull=None, blend=None)
        self._write_depth = setup.gpu.state(depth_test=True, depth_func="always", cull=None, blend=None)

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        builder.add_pass(
            "gbuffer.clear",
            bind=self._bind_clear,
            system=self.name,
            help="nothing seen yet, infinitely far away",
            creates=ATTACHMENTS,
        )
        across, down = tiles_of(view.size)
        count = across * down
        builder.add_pass(
            "gbuffer.classify",
            bind=lambda io: self._bind_classify(io, across, down),
            system=self.name,
            kind="compute",
            reads=("gbuffer.surface", "gbuffer.depth"),
            creates=(
                BufferSpec("gbuffer.tile_flags", 4 * count, help="surfaces that each tile of 16 x 8 pixels shows"),
                BufferSpec("gbuffer.tile_depths", 8 * count, help="their nearest and farthest depth, 0 without any"),
                BufferSpec("gbuffer.tiles_terrain", 16 + 4 * count, help="dispatch and tiles of distant ground"),
                BufferSpec("gbuffer.tiles_near", 16 + 4 * count, help="dispatch and tiles with ground nearby"),
                BufferSpec("gbuffer.tiles_coast", 16 + 4 * count, help="dispatch and tiles where both meet"),
                BufferSpec("gbuffer.tiles_sea", 16 + 4 * count, help="dispatch and tiles of the sea"),
            ),
            only_while=view.view.seen.ground,
            help="tiles by surface, so that each surface is shaded where it is seen only",
        )
        self._tiles_picture.declare(builder, across)
        builder.add_pass(
            "outputs.geometry",
            bind=self._bind_geometry,
            system=self.name,
            reads=("gbuffer.depth", "gbuffer.normal", "gbuffer.surface"),
            help="metres for programs, never jittered",
            creates=(
                TextureSpec("outputs.position", "rgba32f", help="from the camera in planet axes; w: distance"),
                TextureSpec("outputs.normal", "rgba32f", help="unit normal in planet axes; w: surface id"),
            ),
        )
        self._labels.declare(builder, self.name)
        builder.import_("target", kind="framebuffer")
        builder.add_pass(
            "outputs.present",
            bind=self._bind_present,
            system=self.name,
            reads=("composite.ldr",),
            writes=("target",),
            help="the finished picture into the host's framebuffer",
        )
        builder.import_("target_with_depth", kind="framebuffer")
        builder.add_pass(
            "outputs.present_depth",
            bind=lambda io: self._bind_present_depth(io, view.view),
            system=self.name,
            reads=("composite.ldr", "gbuffer.depth"),
            writes=("target_with_depth",),
            help="the finished picture among a host's objects, by its depth buffer",
        )

    def _bind_clear(self, io: PassIO) -> Callable[[], None]:
        target = io.framebuffer(colors=GBUFFER, depth="gbuffer.depth")

        def run() -> None:
            target.use()
            self._write_depth.apply()
            self._gpu.clear(target, depth=0.0)

        return run

    def _bind_classify(self, io: PassIO, width: int, height: int) -> Callable[[], None]:
        surface, depth = io.texture("gbuffer.surface"), io.texture("gbuffer.depth")
        flags, depths = io.buffer("gbuffer.tile_flags"), io.buffer("gbuffer.tile_depths")
        lists = [io.buffer(f"gbuffer.tiles_{n}") for n in ("terrain", "sea", "coast", "near")]

        def run() -> None:
            surface.use(0)
            depth.use(1)
            flags.bind_to_storage_buffer(FLAG_BUFFER)
            depths.bind_to_storage_buffer(1)
            self._classify.set("u_tiles", (width, height))
            self._classify.run(-(-width * height // 64), 1, 1)
            self._gpu.barrier()
            for binding, tiles in zip((TERRAIN_TILES_BUFFER, SEA_TILES_BUFFER, 3, 4), lists, strict=True):
                tiles.bind_to_storage_buffer(binding)
            self._list.set("u_tiles", (width, height))
            self._list.run(1, 1, 1)

        return run

    def _bind_geometry(self, io: PassIO) -> Callable[[], None]:
        target = io.framebuffer(colors=("outputs.position", "outputs.normal"))
        depth, normal, surface = (io.texture(n) for n in ("gbuffer.depth", "gbuffer.normal", "gbuffer.surface"))

        def run() -> None:
            target.use()
            self._write_all.apply()
            depth.use(0)
            normal.use(1)
            surface.use(2)
            self._geometry.render()

        return run

    def _bind_present(self, io: PassIO) -> Callable[[], None]:
        target = io.imported("target")
        picture, source = io.texture("composite.ldr"), io.copy_source("composite.ldr")

        def run() -> None:
            target.value.use()
            self._write_all.apply()
            if self._gpu.copy_color(source, target.value):
                return
            picture.use(0)
            if target.value.viewport[2:] == picture.size:
                self._present.render()
                return
            if self._present_scaled is None:  # most programs do without
                self._present_scaled = self._gpu.fullscreen("outputs/present.frag", defines={"SCALED": 1})
            self._present_scaled.render()

        return run

    def _bind_present_depth(self, io: PassIO, view: View) -> Callable[[], None]:
        target = io.imported("target_with_depth")
        picture, depth = io.texture("composite.ldr"), io.texture("gbuffer.depth")
        draw = self._present_depth
        if draw is None:  # most programs do without
            draw = self._present_depth = self._gpu.fullscreen("outputs/present_depth.frag")
        state = self._gpu.state
        nearer = {side: state(depth_test=True, depth_func=test) for side, test in ((True, ">="), (False, "<="))}

        def run() -> None:
            host_depth = view.frame.host_depth
            assert host_depth is not None, "who asks for target_with_depth says how its depth buffer holds distances"
            target.value.use()
            nearer[host_depth[1] > 0.0].apply()
            picture.use(0)
            depth.use(1)
            draw.set("u_host_depth", host_depth)
            draw.render()

        return run
