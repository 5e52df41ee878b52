"""SeaShading: light of the sea's pixels, from the G-buffer that the mesh passes have filled."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...components import Ocean, Planet
from ...engine.contracts import bind_contracts, contract_reads
from ...engine.graph import GraphBuilder, PassIO
from ...engine.settings import revision, with_overrides
from ...engine.system import Frame, Setup, ViewInfo
from .block import OCEAN_BINDING, OceanBlock, ocean_block

__all__ = ["GBUFFER", "SeaShading"]

GBUFFER = ("gbuffer.normal", "gbuffer.attributes", "gbuffer.surface")


class SeaShading:
    """Part of OceanSystem: the water's uniform block and the passes that turn the G-buffer's sea into radiance."""

    def __init__(self, name: str) -> None:
        self._name = name

    def setup(self, setup: Setup) -> None:
        self._world = setup.world
        self._block = setup.gpu.uniform_block(OceanBlock, OCEAN_BINDING, "ocean")
        self._written: tuple[Any, ...] | None = None
        self._shade = setup.gpu.compute("ocean/shade.comp")

    def update(self, frame: Frame) -> None:
        """Write and bind the water's block."""
        ocean = frame.world.get(frame.planet, Ocean)
        proxy = frame.world.resource(f"proxy.{frame.view_index}")
        written = (revision(ocean), frame.view_index, proxy.generation)
        if written != self._written:
            self._written = written
            radius = frame.world.get(frame.planet, Planet).radius_m
            ocean = with_overrides(ocean, "ocean", frame.settings)
            self._block.write(ocean_block(ocean, proxy.lattice.direction, radius))
        self._block.bind()

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        builder.add_pass(
            "ocean.shade",
            system=self._name,
            bind=self._bind_shade,
            kind="compute",
            reads=("gbuffer.depth", *GBUFFER, "ocean.rough", "gbuffer.tiles_sea", *contract_reads(self._world)),
            writes=("scene.radiance",),
            after=("sky.shade",),
            after_optional=("terrain.shade",),
            help="light of sea pixels",
        )

    def _bind_shade(self, io: PassIO) -> Callable[[], None]:
        radiance, tiles = io.texture("scene.radiance"), io.buffer("gbuffer.tiles_sea")
        textures = [io.texture(n) for n in ("gbuffer.depth", *GBUFFER, "ocean.rough")]
        bind_air = bind_contracts(self._world, io)

        def run() -> None:
            bind_air()
            radiance.bind_to_image(0, read=False, write=True)
            tiles.bind_to_storage_buffer(7)
            for unit, texture in enumerate(textures):
                texture.use(unit)
            self._shade.run_indirect(tiles)

        return run
