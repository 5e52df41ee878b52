"""Coasts: the pass that draws the line between land and water, from the height function."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from ...components import Ocean
from ...engine.blocks.bindings import (
    ATTRIBUTES_UNIT,
    COAST_ATTRIBUTES_IMAGE,
    COAST_LAND_BUFFER,
    COAST_LIST_BUFFER,
    COAST_MORE_BUFFER,
    COAST_NORMAL_IMAGE,
    COAST_SURFACE_IMAGE,
    DEPTH_UNIT,
    FLAG_BUFFER,
    SEA_TILES_BUFFER,
    SURFACE_UNIT,
    TERRAIN_TILES_BUFFER,
    TILE_BUFFER,
)
from ...engine.frame import View, ViewInfo
from ...engine.frame.gbuffer import GBUFFER, tiles_of
from ...engine.gpu import Compute, GpuScope
from ...engine.graph import BufferSpec, GraphBuilder, PassIO
from ...engine.settings import Settings
from ...engine.world import World
from .view import TerrainView

__all__ = ["Coasts"]

_LISTS = ("terrain.coast_asked", "terrain.coast_land", "terrain.coast_more")
_GROWING = ("gbuffer.tile_flags", "gbuffer.tiles_terrain", "gbuffer.tiles_sea")
_GROWING_AT = (FLAG_BUFFER, TERRAIN_TILES_BUFFER, SEA_TILES_BUFFER)
_RG16_SNORM = 0x8F99  # moderngl takes the texture for an unsigned one
_GROWTH = 3
"""From far away meshes know nothing of lakes and islands that are tens of kilometres wide: so many times tiles are
added into which one goes on."""
_DEEP_M = 100.0


class Coasts:
    """The line between land and water of one planet, for all views: the meshes meet along straight edges some pixels
    long, the height function knows better. It is asked at each pixel beside a coast that may be either, once for each
    of such blocks of 2 x 2, or at every fourth pixel and interpolated between (knob terrain.coast_px)."""

    def __init__(self, gpu: GpuScope, world: World, settings: Settings, shader: Callable[..., Compute]) -> None:
        """shader: makes a compute shader of a file and names that are defined."""
        self._gpu, self._world, self._settings, self._shader = gpu, world, settings, shader

    def declare(
        self,
        builder: GraphBuilder,
        info: ViewInfo,
        view: Callable[[], TerrainView],
        file: str,
        bind_heights: Callable[[], None],
        seen: Callable[[], bool],
    ) -> None:
        """file: the backend's own shader for it, or ""; view and bind_heights: of the view, once it is drawn; seen:
        whether any ground is."""
        across, down = tiles_of(info.size)
        pixels = 4 if self._fourth() else info.size[0] * info.size[1]  # those between are not listed
        counts = (pixels, pixels, across * down)
        texts = ("pixels that may be land or water", "those that become land", "tiles that are added")
        specs = [
            BufferSpec(name, 16 + 4 * count, help=f"dispatch, and {text}")
            for name, count, text in zip(_LISTS, counts, texts, strict=True)
        ]
        builder.add_pass(
            "terrain.coast",
            kind="compute",
            system="terrain",
            bind=lambda io: self._bind(io, info.view, view, file, bind_heights),
            reads=("gbuffer.depth", "gbuffer.tiles_coast"),
            writes=(*GBUFFER, *(() if file else _GROWING)),
            stage="detail",
            creates=() if file else specs,
            only_while=seen,
            help="the line between land and water, from the height function at each pixel",
        )

    def _bind(
        self, io: PassIO, of: View, view: Callable[[], TerrainView], file: str, bind_heights: Callable[[], None]
    ) -> Callable[[], None]:
        tiles, depth = io.buffer("gbuffer.tiles_coast"), io.texture("gbuffer.depth")
        images = [io.texture(n) for n in GBUFFER]
        own = self._shader(file) if file else None
        ask = None if file else self._bind_asking(io, of, view())

        def run() -> None:
            depth.use(DEPTH_UNIT)
            images[1].use(ATTRIBUTES_UNIT)
            images[2].use(SURFACE_UNIT)
            images[0].bind_to_image(COAST_NORMAL_IMAGE, read=False, write=True, format=_RG16_SNORM)
            images[1].bind_to_image(COAST_ATTRIBUTES_IMAGE, read=False, write=True)
            images[2].bind_to_image(COAST_SURFACE_IMAGE, read=False, write=True)
            bind_heights()
            tiles.bind_to_storage_buffer(TILE_BUFFER)
            if own is not None:
                own.run_indirect(tiles)
            elif ask is not None:
                ask()

        return run

    def _bind_asking(self, io: PassIO, of: View, view: TerrainView) -> Callable[[], None]:
        """Of the tiles that both surfaces share, and from far away of those into which a lake goes on."""
        begin, grow = self._shader("terrain/coast_begin.comp"), self._shader("terrain/coast_grow.comp")
        tiles, (asked, land, more) = io.buffer("gbuffer.tiles_coast"), (io.buffer(name) for name in _LISTS)
        growing = [io.buffer(name) for name in _GROWING]
        across, down = tiles_of(io.size)
        barrier = self._gpu.barrier
        ask = self._bind_between(view) if self._fourth() else self._bind_lists(of, view, asked, land)

        def run() -> None:
            grow.set("u_tiles", (across, down))
            for turn in range(1 + (_GROWTH if view.far else 0)):
                more.bind_to_storage_buffer(COAST_MORE_BUFFER)
                land.bind_to_storage_buffer(COAST_LAND_BUFFER)
                asked.bind_to_storage_buffer(COAST_LIST_BUFFER)
                begin.run()
                barrier()
                if turn:
                    for point, buffer in zip(_GROWING_AT, growing, strict=True):
                        buffer.bind_to_storage_buffer(point)
                    grow.run(-(-across * down // 64))
                    barrier()
                    more.bind_to_storage_buffer(TILE_BUFFER)
                ask(more if turn else tiles)
                if view.far and turn < _GROWTH:
                    barrier()

        return run

    def _fourth(self) -> bool:
        """Whether heights are asked at every fourth pixel."""
        return int(self._settings["terrain.coast_px"]) == 4

    def _bind_between(self, view: TerrainView) -> Callable[[Any], None]:
        """Asks at every fourth pixel."""
        near, wide = self._shader("terrain/coast.comp"), self._shader("terrain/coast.comp", "TERRAIN_FLOAT")

        def run(tiles: Any) -> None:
            (wide if view.wide else near).run_indirect(tiles)

        return run

    def _bind_lists(self, of: View, view: TerrainView, asked: Any, land: Any) -> Callable[[Any], None]:
        """Asks at the pixels that may be either, by lists of them."""
        # In full: a test looks for the names of all shaders.
        find_file, far_file, ask_file = "terrain/coast_find.comp", "terrain/coast_far.comp", "terrain/coast_ask.comp"
        # The height alone has no gradient, which a block of pixels is asked by.
        alone = int(self._settings["terrain.coast_px"]) == 1
        here = ("COAST_HERE",) if alone else ()
        find, find_wide = self._shader(find_file), self._shader(find_file, "TERRAIN_FLOAT", *here)
        ask, ask_wide = self._shader(ask_file), self._shader(ask_file, "TERRAIN_FLOAT")
        listed = self._shader(far_file, "TERRAIN_FLOAT") if alone else ask_wide
        whole = self._shader(find_file if alone else ask_file, "TERRAIN_FLOAT", *here, "COAST_TILES")
        barrier = self._gpu.barrier

        def run(tiles: Any) -> None:
            frame = of.frame
            first = whole if view.farther else find_wide if view.wide else find
            lists = alone or not view.farther
            if lists:
                first.set("u_opaque_m", self._opaque_m())
            if alone and view.wide:
                # Either surface may become the other.
                board, both = frame.checkerboard, frame.checkered.issuperset(("terrain", "ocean"))
                first.set("u_checkerboard", -1 if board is None or not both else board)
            first.run_indirect(tiles)
            if lists:
                barrier()
                (listed if view.wide else ask).run_indirect(asked)
            if view.wide and alone:
                barrier()
                land.bind_to_storage_buffer(COAST_LIST_BUFFER)
                ask_wide.run_indirect(land)

        return run

    def _opaque_m(self) -> float:
        """Water that is deeper lets less than a step of a picture through from its bed, and carries waves as the deep
        sea does."""
        ocean = self._world.query(Ocean)[0][1][0]
        loss = min(a + b for a, b in zip(ocean.absorption_per_m, ocean.scattering_per_m, strict=True))
        return max(_DEEP_M, 0.5 * math.log(510.0) / max(loss, 1e-6))
