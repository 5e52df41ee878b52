"""SeaShading: light of the sea's pixels, from the G-buffer that the mesh passes filled; water before the lens."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ...components import Ocean, Planet
from ...engine.contracts import bind_contracts, contract_reads
from ...engine.graph import BufferSpec, GraphBuilder, PassIO
from ...engine.settings import revision, with_overrides
from ...engine.system import Frame, Setup, ViewInfo
from .block import OCEAN_BINDING, OceanBlock, ocean_block

__all__ = ["GBUFFER", "LENS_REACH_M", "SEA_TOP", "SeaShading"]

GBUFFER = ("gbuffer.normal", "gbuffer.attributes", "gbuffer.surface")
SEA_TOP = "sea_top_m"
"""World resource: no water is higher above the reference sphere than this, with room for a lens."""
LENS_REACH_M = 0.3
"""No point of the near plane is farther from the camera."""

_TILE = (16, 8)
_KINDS = ("open", "rich", "below")
_CONTRACTS = {"water": "ocean/water.glsl", "waterline": "ocean/waterline.glsl"}
_FAR_M = 1.0e9


class SeaShading:
    """Part of OceanSystem: the water's uniform block, the shader contracts ``water`` and ``waterline``, and the passes
    that turn the G-buffer's sea into radiance."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._near_water = False

    def setup(self, setup: Setup) -> None:
        self._world = setup.world
        self._gpu = setup.gpu
        self._shaders = setup.gpu.gpu.shaders
        for contract, file in _CONTRACTS.items():
            self._shaders.provide(contract, file, owner=self._name)
        self._block = setup.gpu.uniform_block(OceanBlock, OCEAN_BINDING, "ocean")
        self._held: OceanBlock | None = None
        self._written: tuple[Any, ...] | None = None
        turns = int(setup.settings["ocean.reflections"])
        mirrors = {"OCEAN_REFLECTIONS": turns} if turns else {}
        self._classify = setup.gpu.compute("ocean/classify.comp")
        self._list = setup.gpu.compute("ocean/list_tiles.comp")
        defines = {"open": mirrors, "rich": {**mirrors, "OCEAN_RICH": 1}, "below": {"OCEAN_BELOW": 1}}
        self._shade = {k: setup.gpu.compute("ocean/shade.comp", defines=defines[k]) for k in _KINDS}
        stored = str(setup.settings.get("sky.radiance_format", "rgba32f"))
        self._under = setup.gpu.compute("ocean/under.comp", defines={"SCENE_FORMAT": stored})

    def release(self) -> None:
        self._shaders.withdraw(self._name)
        self._world.resources.pop(SEA_TOP, None)

    def begin(self, frame: Frame) -> None:
        """Tell the others how high the water reaches."""
        frame.world.set_resource(SEA_TOP, frame.world.get(frame.planet, Ocean).sea_level_m + LENS_REACH_M)

    def update(self, frame: Frame) -> None:
        """Write and bind the water's block."""
        ocean = frame.world.get(frame.planet, Ocean)
        proxy = frame.world.resource(f"proxy.{frame.view_index}")
        radius = frame.world.get(frame.planet, Planet).radius_m
        written = (revision(ocean), frame.view_index, proxy.generation)
        if written != self._written or self._held is None:
            self._written = written
            self._held = ocean_block(with_overrides(ocean, "ocean", frame.settings), proxy.lattice.direction, radius)
        self._held.lens = self._lens(frame, ocean, radius)
        self._near_water = self._held.lens[3] < LENS_REACH_M
        self._block.write(self._held)
        self._block.bind()

    @staticmethod
    def _lens(frame: Frame, ocean: Ocean, radius_m: float) -> tuple[float, float, float, float]:
        """The surface as a plane at the camera: its normal in planet axes, and the camera's height over it in metres.
        Far from the water that height is so large that no rounding changes a pixel's side."""
        distance = float(np.linalg.norm(frame.camera.position_m))
        zenith = frame.camera.position_m / distance
        over = distance - radius_m - ocean.sea_level_m
        if abs(over) > LENS_REACH_M:
            over = _FAR_M if over > 0.0 else -_FAR_M
        return (*zenith, over)

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        across, down = (-(-n // t) for n, t in zip(view.size, _TILE, strict=True))
        count = across * down
        builder.add_pass(
            "ocean.classify",
            system=self._name,
            bind=lambda io: self._bind_classify(io, across, down),
            kind="compute",
            reads=("gbuffer.depth", "gbuffer.attributes", "gbuffer.surface"),
            creates=(
                BufferSpec("ocean.tile_flags", 4 * count, help="what each tile's sea needs"),
                BufferSpec("ocean.tiles_open", 16 + 4 * count, help="dispatch and tiles of deep open water"),
                BufferSpec("ocean.tiles_rich", 16 + 4 * count, help="dispatch and tiles with shallows, foam or ice"),
                BufferSpec("ocean.tiles_below", 16 + 4 * count, help="dispatch and tiles of the surface from below"),
            ),
            help="tiles of the sea by what they need",
        )
        builder.add_pass(
            "ocean.shade",
            system=self._name,
            bind=self._bind_shade,
            kind="compute",
            reads=(
                "gbuffer.depth",
                *GBUFFER,
                "ocean.rough",
                *(f"ocean.tiles_{k}" for k in _KINDS),
                "gbuffer.tiles_terrain",
                *contract_reads(self._world),
            ),
            writes=("scene.radiance",),
            after=("sky.shade",),
            after_optional=("terrain.shade",),
            help="light of sea pixels",
        )
        builder.add_pass(
            "ocean.under",
            system=self._name,
            bind=lambda io: self._bind_under(io, across, down),
            kind="compute",
            reads=("gbuffer.depth", *contract_reads(self._world)),
            writes=("scene.radiance",),
            after=("ocean.shade",),
            after_optional=("terrain.shade", "props.shade", "stars.draw"),
            when=lambda: self._near_water,
            help="water between the lens and what a pixel shows",
        )

    def _bind_classify(self, io: PassIO, across: int, down: int) -> Callable[[], None]:
        textures = [io.texture(n) for n in ("gbuffer.depth", "gbuffer.attributes", "gbuffer.surface")]
        buffers = [io.buffer(f"ocean.{n}") for n in ("tile_flags", *(f"tiles_{k}" for k in _KINDS))]

        def run() -> None:
            for unit, texture in enumerate(textures):
                texture.use(unit)
            for unit, buffer in enumerate(buffers):
                buffer.bind_to_storage_buffer(unit)
            self._classify.set("u_tiles", (across, down))
            self._classify.run(-(-across * down // 64), 1, 1)
            self._gpu.gpu.barrier()
            self._list.set("u_tiles", (across, down))
            self._list.run(1, 1, 1)

        return run

    def _bind_shade(self, io: PassIO) -> Callable[[], None]:
        radiance, ground = io.texture("scene.radiance"), io.buffer("gbuffer.tiles_terrain")
        textures = [io.texture(n) for n in ("gbuffer.depth", *GBUFFER, "ocean.rough", "scene.radiance")]
        parts = [(self._shade[k], io.buffer(f"ocean.tiles_{k}")) for k in _KINDS]
        bind_air = bind_contracts(self._world, io)

        def run() -> None:
            bind_air()
            radiance.bind_to_image(0, read=False, write=True)
            ground.bind_to_storage_buffer(6)
            for unit, texture in enumerate(textures):
                texture.use(unit)
            for shade, tiles in parts:
                tiles.bind_to_storage_buffer(7)
                shade.run_indirect(tiles)

        return run

    def _bind_under(self, io: PassIO, across: int, down: int) -> Callable[[], None]:
        radiance, depth = io.texture("scene.radiance"), io.texture("gbuffer.depth")
        bind_air = bind_contracts(self._world, io)

        def run() -> None:
            bind_air()
            depth.use(0)
            radiance.bind_to_image(0, read=True, write=True)
            self._under.run(across, down, 1)

        return run
