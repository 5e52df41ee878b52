"""Rivers and lakes in the picture: the passes that make a surface of water of the ground that lies under theirs."""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from ...engine.blocks.bindings import (
    ATTRIBUTES_UNIT,
    DEPTH_UNIT,
    FLAG_BUFFER,
    LAND_WATER_UNIT,
    NARROW_WATER_BUFFER,
    SEA_TILES_BUFFER,
    SURFACE_UNIT,
    TILE_BUFFER,
    WATER_LINE_BUFFER,
    WIDE_WATER_BUFFER,
)
from ...engine.frame import ViewInfo
from ...engine.frame.gbuffer import GBUFFER, tiles_of
from ...engine.gpu import Compute, GpuScope, Program, VertexArray
from ...engine.graph import BufferSpec, GraphBuilder, PassIO, TextureSpec

__all__ = ["LAND_WATER", "NARROW_TILES", "LandWater"]

LAND_WATER = "terrain.land_water"
"""Texture with what terrain/land_water.comp found of each pixel near water, 0 elsewhere."""
NARROW_TILES = "terrain.tiles_narrow_water"
"""Buffer: dispatch and tiles of which it found some to be partly water."""
_TILES, _WIDE, _LINES = "terrain.tiles_water", "terrain.tiles_waters", "terrain.water_lines"
_RECORD = 32
"""Numbers in _LINES by the tile: WATER_RECORD of terrain/tile_waters.glsl."""
_FIND = "terrain/land_water.comp"
_CORNERS = 6
"""Of two triangles."""


class LandWater:
    """Rivers and lakes of one planet, for all views. Their pixels become the sea's, whose passes draw them; those of
    narrower rivers stay the ground's, which knows how much of them is water."""

    def __init__(self, gpu: GpuScope, shader: Callable[..., Compute]) -> None:
        """shader: makes a compute shader of a file."""
        self._gpu, self._shader = gpu, shader
        self._drawn: tuple[Program, VertexArray] | None = None
        self._over = gpu.state(depth_test=True, depth_func="always")

    def declare(
        self,
        builder: GraphBuilder,
        info: ViewInfo,
        bind_heights: Callable[[], None],
        far: Callable[[], bool],
        seen: Callable[[], bool],
    ) -> None:
        """bind_heights: of the view, once it is drawn; far: whether all pixels are so wide that floats do; seen:
        whether any ground is."""
        across, down = tiles_of(info.size)
        builder.add_pass(
            "terrain.land_water",
            kind="compute",
            system="terrain",
            bind=lambda io: self._bind_find(io, (across, down), bind_heights, far),
            reads=("gbuffer.depth", "gbuffer.attributes", "gbuffer.surface"),
            writes=("gbuffer.tile_flags", "gbuffer.tiles_sea"),
            creates=(
                TextureSpec(LAND_WATER, "rgba32ui", help="rivers and lakes in a pixel"),
                BufferSpec(_TILES, 16 + 4 * across * down, help="dispatch and tiles near rivers and lakes"),
                BufferSpec(_WIDE, 16 + 4 * across * down, help="the same, with more lines than are listed"),
                BufferSpec(NARROW_TILES, 16 + 4 * across * down, help="the same, with rivers narrower than a pixel"),
                BufferSpec(_LINES, 4 * _RECORD * across * down, help="lines of water that pass those tiles"),
            ),
            after=("terrain.coast",),
            stage="detail",
            only_while=seen,
            help="rivers and lakes at each pixel near any, from their lines",
        )
        builder.add_pass(
            "terrain.water_surface",
            system="terrain",
            bind=lambda io: self._bind_draw(io, across, across * down),
            reads=(LAND_WATER, "gbuffer.tile_flags"),
            writes=("gbuffer.depth", *GBUFFER),
            after=("terrain.coast",),
            stage="detail",
            only_while=seen,
            help="the surface of rivers and lakes over their beds",
        )

    def _bind_find(
        self,
        io: PassIO,
        tiles: tuple[int, int],
        bind_heights: Callable[[], None],
        far: Callable[[], bool],
    ) -> Callable[[], None]:
        begin, sort = self._shader("terrain/begin_water.comp"), self._shader("terrain/list_water.comp")
        near, distant = self._shader(_FIND), self._shader(_FIND, "WATER_FAR", "TERRAIN_FLOAT")
        unlisted = self._shader(_FIND, "WATER_WIDE", "WATER_FAR", "TERRAIN_FLOAT")
        units = {"gbuffer.depth": DEPTH_UNIT, "gbuffer.attributes": ATTRIBUTES_UNIT, "gbuffer.surface": SURFACE_UNIT}
        textures = [(unit, io.texture(name)) for name, unit in units.items()]
        points = {
            "gbuffer.tile_flags": FLAG_BUFFER,
            _WIDE: WIDE_WATER_BUFFER,
            "gbuffer.tiles_sea": SEA_TILES_BUFFER,
            NARROW_TILES: NARROW_WATER_BUFFER,
            _LINES: WATER_LINE_BUFFER,
        }
        buffers = [(point, io.buffer(name)) for name, point in points.items()]
        none, plain = io.framebuffer(colors=(LAND_WATER,)), self._gpu.state()
        few, wide, found, barrier = io.buffer(_TILES), io.buffer(_WIDE), io.texture(LAND_WATER), self._gpu.barrier

        def run() -> None:
            none.use()
            plain.apply()
            self._gpu.clear(none, depth=0.0)
            for unit, texture in textures:
                texture.use(unit)
            for point, buffer in buffers:
                buffer.bind_to_storage_buffer(point)
            few.bind_to_storage_buffer(TILE_BUFFER)
            bind_heights()
            begin.run()
            barrier()
            sort.set("u_tiles", tiles)
            sort.run(-(-tiles[0] * tiles[1] // 64))
            barrier()
            found.bind_to_image(0, read=False, write=True)
            with self._gpu.apart():  # each tile's pixels are its own
                for shader, listed in ((distant if far() else near, few), (unlisted, wide)):
                    listed.bind_to_storage_buffer(TILE_BUFFER)
                    shader.set("u_tiles", tiles)
                    shader.run_indirect(listed)

        return run

    def _bind_draw(self, io: PassIO, across: int, count: int) -> Callable[[], None]:
        if self._drawn is None:
            made = self._gpu.program(vertex="terrain/land_water.vert", fragment="terrain/land_water.frag")
            self._drawn = made, self._gpu.vertex_array(made)
        program, array = self._drawn
        target = io.framebuffer(colors=GBUFFER, depth="gbuffer.depth")
        found, flags = io.texture(LAND_WATER), io.buffer("gbuffer.tile_flags")

        def run() -> None:
            target.use()
            self._over.apply()
            found.use(LAND_WATER_UNIT)
            flags.bind_to_storage_buffer(FLAG_BUFFER)
            program.set("u_across", across)
            array.render(moderngl.TRIANGLES, _CORNERS, instances=count)

        return run
