"""GroundLabels: albedo and material of the ground's pixels, for programs."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from ...engine.blocks.bindings import LAND_WATER_UNIT, RADIANCE_IMAGE, TILE_BUFFER
from ...engine.frame.contracts import bind_contracts, contract_reads
from ...engine.frame.gbuffer import GBUFFER, GBUFFER_UNITS
from ...engine.frame.labels import LABELS
from ...engine.gpu import Compute
from ...engine.graph import GraphBuilder, PassIO
from ...engine.world import World
from .land_water import LAND_WATER

__all__ = ["GroundLabels", "LabelledGround"]

_ALBEDO = LABELS[0]
_TILES = ("gbuffer.tiles_terrain", "gbuffer.tiles_near")


class LabelledGround(NamedTuple):
    """What a view's ground is: file: of the shader. cover, rivers: whether trees stand on it and water flows. clutter:
    whether things may stand on it, which the shader has to know. bind: binds the ground's heights and materials."""

    file: str
    cover: bool
    rivers: bool
    clutter: Callable[[], bool]
    bind: Callable[[], None]


class GroundLabels:
    """Part of TerrainSystem: a pass that runs while somebody reads outputs.albedo."""

    def __init__(self, world: World, shader: Callable[..., Compute]) -> None:
        """shader: makes a compute shader of a file and flags."""
        self._world, self._shader = world, shader

    def declare(self, builder: GraphBuilder, ground: LabelledGround, seen: Callable[[], bool]) -> None:
        """seen: whether any ground is."""
        builder.add_pass(
            "terrain.labels",
            kind="compute",
            system="terrain",
            bind=lambda io: self._bind(io, ground),
            reads=(
                *("gbuffer.depth", *GBUFFER, *_TILES, *contract_reads(self._world)),
                *((LAND_WATER,) if ground.rivers else ()),
            ),
            writes=(_ALBEDO,),
            stage="opaque",
            only_while=seen,
            help="albedo and material of terrain pixels",
        )

    def _bind(self, io: PassIO, ground: LabelledGround) -> Callable[[], None]:
        albedo = io.texture(_ALBEDO)
        textures = [(unit, io.texture(name)) for name, unit in GBUFFER_UNITS.items()]
        if ground.rivers:
            textures.append((LAND_WATER_UNIT, io.texture(LAND_WATER)))
        bind_sources = bind_contracts(self._world, io)
        flags = [*(["GROUND_COVER"] if ground.cover else []), *(["GROUND_RIVERS"] if ground.rivers else [])]
        plain = self._shader(ground.file, "SHADE_EVERY", *flags)
        full = self._shader(ground.file, "SHADE_EVERY", *flags, "GROUND_CLUTTER")
        far, near = (io.buffer(name) for name in _TILES)

        def run() -> None:
            bind_sources()
            albedo.bind_to_image(RADIANCE_IMAGE, read=False, write=True)
            for unit, texture in textures:
                texture.use(unit)
            ground.bind()
            for tiles, shader in ((far, plain), (near, full if ground.clutter() else plain)):
                tiles.bind_to_storage_buffer(TILE_BUFFER)
                shader.run_indirect(tiles)

        return run
