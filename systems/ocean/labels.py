"""SeaLabels: albedo and material of the water's pixels, for programs."""

from __future__ import annotations

from collections.abc import Callable

from ...engine.blocks.bindings import RADIANCE_IMAGE, TILE_BUFFER
from ...engine.frame.contracts import bind_contracts, contract_reads
from ...engine.frame.gbuffer import GBUFFER, GBUFFER_UNITS
from ...engine.frame.labels import LABELS
from ...engine.gpu import Compute, GpuScope
from ...engine.graph import GraphBuilder, PassIO
from ...engine.world import World

__all__ = ["SeaLabels"]

_ALBEDO = LABELS[0]
_TILES = "gbuffer.tiles_sea"


class SeaLabels:
    """Part of OceanSystem: a pass that runs while somebody reads outputs.albedo."""

    def __init__(self, gpu: GpuScope, world: World) -> None:
        self._gpu, self._world = gpu, world
        self._shader: Compute | None = None

    def declare(self, builder: GraphBuilder, system: str, seen: Callable[[], bool]) -> None:
        """seen: whether any water is."""
        builder.add_pass(
            "ocean.labels",
            kind="compute",
            system=system,
            bind=self._bind,
            reads=("gbuffer.depth", *GBUFFER, "ocean.rough", _TILES, *contract_reads(self._world)),
            writes=(_ALBEDO,),
            stage="water",
            only_while=seen,
            help="albedo and material of the water's pixels",
        )

    def _bind(self, io: PassIO) -> Callable[[], None]:
        shader = self._shader
        if shader is None:  # most programs do without
            shader = self._shader = self._gpu.compute("ocean/labels.comp")
        albedo, tiles = io.texture(_ALBEDO), io.buffer(_TILES)
        textures = [(unit, io.texture(name)) for name, unit in (GBUFFER_UNITS | {"ocean.rough": 4}).items()]
        bind_sources = bind_contracts(self._world, io)

        def run() -> None:
            bind_sources()
            albedo.bind_to_image(RADIANCE_IMAGE, read=False, write=True)
            for unit, texture in textures:
                texture.use(unit)
            tiles.bind_to_storage_buffer(TILE_BUFFER)
            shader.run_indirect(tiles)

        return run
