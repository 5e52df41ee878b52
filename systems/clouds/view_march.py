"""The march for a view: tiles by what they may see, rays through those with cloud, and debug views of both."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ...engine.blocks.bindings import CLOUD_DEPTH_UNIT, CLOUD_SUN_UNIT, FLAG_BUFFER, TILE_BUFFER
from ...engine.frame import ViewInfo
from ...engine.frame.contracts import bind_contracts, contract_reads
from ...engine.gpu import Compute, GpuScope
from ...engine.graph import BufferSpec, GraphBuilder, PassIO, TextureSpec
from ...engine.world import World
from .history import NONE, STILL, History
from .picture import CloudPicture
from .shadow_pass import SUN
from .view_block import CLOUD_VIEW

__all__ = ["DISTANCE", "MAPPED", "RAYS", "UPSAMPLED", "MarchSteps", "ViewMarch"]

RAYS, DISTANCE, UPSAMPLED = "clouds.rays", "clouds.distance", "clouds.upsampled"
_FLAGS, _TILES = "clouds.tile_flags", "clouds.tiles"
TILE = (8, 4)
"""Rays of a tile: a workgroup's."""
SUN_MAPPED = 8.0
"""Steps towards the sun in clouds; more of them are as good as the maps of the shadow, and have no need of these."""
MAPPED: Mapping[str, Any] = {"CLOUD_MAPPED": 1}
"""Define of clouds/sun_optical_depth.glsl: the rest of the way to the sun comes from the maps."""
NO_CIRRUS: Mapping[str, Any] = {"CLOUD_NO_CIRRUS": 1}
"""Define of clouds/density.glsl: there is no cirrus where the program runs."""


@dataclass(frozen=True)
class MarchSteps:
    """Sizes of the march's steps, as uniforms of clouds/intervals.glsl.

    layer: short steps through a layer's thickness; growth: of a step's length with distance, m/m; sun: steps towards
    the sun through a layer.
    """

    layer: float
    growth: float
    sun: float

    @classmethod
    def of(cls, settings: Mapping[str, Any]) -> MarchSteps:
        """A quality's."""
        return cls(*(float(settings[f"clouds.{name}"]) for name in ("fine_steps", "step_growth", "sun_steps")))

    def give(self, program: Compute) -> None:
        program.set("u_layer_steps", self.layer)
        program.set("u_step_growth", self.growth)
        program.set("u_sun_steps", self.sun)


class ViewMarch:
    """Passes ``clouds.classify`` and ``clouds.march``, and ``clouds.debug`` while somebody looks at what it makes.

    picture: what the rays are for. What it marches with comes from `tune`.
    """

    def __init__(self, gpu: GpuScope, world: World, system: str, picture: CloudPicture) -> None:
        self._gpu, self._world, self._system, self._picture = gpu, world, system, picture
        self._defines: Mapping[str, Any] = {}
        self._classify: Compute
        self._list = gpu.compute("clouds/list_tiles.comp")
        self._between = gpu.compute("clouds/upsample_rays.comp", picture.defines)
        self._march: Compute
        self._no_cirrus: Compute
        self._steps = MarchSteps(0.0, 0.0, 0.0)
        self._debug: Compute | None = None
        self._programs: set[Compute] = set()

    def tune(self, steps: MarchSteps, defines: Mapping[str, Any]) -> None:
        """defines: of clouds/scattered.glsl, and CLOUD_FINEST."""
        mapped = steps.sun <= SUN_MAPPED
        given = {**self._picture.defines, **defines, **(MAPPED if mapped else {})}
        if given != self._defines:
            self._defines = given
            for program in self._programs:
                self._gpu.free(program)
            self._classify = self._gpu.compute("clouds/classify.comp", self._picture.defines)
            self._march = self._program("clouds/view_march.comp")
            # Steps all the way to the sun meet layers above, which may be cirrus.
            self._no_cirrus = self._program("clouds/view_march.comp", NO_CIRRUS) if mapped else self._march
            self._programs = {self._classify, self._march, self._no_cirrus}
            if self._debug is not None:
                self._debug = self._program("clouds/debug.comp")
                self._programs.add(self._debug)
        self._steps = steps
        for program in self._programs:
            steps.give(program)

    def _program(self, file: str, more: Mapping[str, Any] = {}) -> Compute:
        return self._gpu.compute(file, {**self._defines, **more})

    def declare(
        self, builder: GraphBuilder, view: ViewInfo, history: Callable[[], History], bind_clouds: Callable[[], None]
    ) -> None:
        """history: of the frame; bind_clouds: binds layers, noise and weather."""
        size, depth = self._picture.rays(view.size), self._picture.depth
        tiles = -(-size[0] // TILE[0]) * -(-size[1] // TILE[1])
        air = contract_reads(self._world, but=self._system)
        builder.add_pass(
            "clouds.classify",
            kind="compute",
            bind=lambda io: self._bind_classify(io, history, bind_clouds),
            system=self._system,
            reads=(CLOUD_VIEW, depth),
            creates=(
                TextureSpec(RAYS, "rgba32f", size, "persistent", help="light of clouds, and what they leave"),
                TextureSpec(DISTANCE, "r32f", size, "persistent", help="mean distance of the clouds"),
                BufferSpec(_FLAGS, 4 * tiles, "persistent", help="what each tile of rays meets"),
                BufferSpec(_TILES, 32 + 4 * tiles, "persistent", help="dispatches, tiles without cirrus and with"),
            ),
            when=lambda: not history().skip,
            help="tiles of rays that may see cloud",
        )
        builder.add_pass(
            "clouds.march",
            kind="compute",
            bind=lambda io: self._bind_march(io, history, bind_clouds),
            system=self._system,
            reads=(CLOUD_VIEW, depth, SUN, _TILES, *air),
            writes=(RAYS, DISTANCE),
            after=("clouds.classify",),
            when=lambda: not history().skip,
            help="clouds along one ray of each block of pixels, where there are any",
        )
        builder.add_pass(
            "clouds.debug",
            kind="compute",
            bind=lambda io: self._bind_debug(io, history, bind_clouds),
            system=self._system,
            reads=(CLOUD_VIEW, depth, SUN, _FLAGS, *air),
            creates=(
                TextureSpec("debug.cloud_tiles", "rgba8", size, help="dark: nothing, blue: air only, else cloud"),
                TextureSpec("debug.cloud_steps", "r32f", size, help="places looked at, without the sun's"),
            ),
            help="classes of tiles, and steps of the march",
        )

    def declare_between(self, builder: GraphBuilder, view: ViewInfo, history: Callable[[], History]) -> None:
        """Pass ``clouds.between``: rays of the blocks that have none of their own in this frame."""
        size = self._picture.rays(view.size)
        builder.add_pass(
            "clouds.between",
            kind="compute",
            bind=lambda io: self._bind_between(io, history),
            system=self._system,
            reads=(self._picture.depth,),
            writes=(RAYS, DISTANCE),
            creates=(TextureSpec(UPSAMPLED, "rgba32f", size, "persistent", help="rays, where there is no history"),),
            after=("clouds.march",),
            after_optional=("clouds.shafts",),
            when=lambda: history().checkerboard >= 0 and not history().skip,
            help="rays between those that were followed, while something moves",
        )

    def _bind_between(self, io: PassIO, history: Callable[[], History]) -> Callable[[], None]:
        color, distance, depth = io.texture(RAYS), io.texture(DISTANCE), io.texture(self._picture.depth)
        upsampled = io.texture(UPSAMPLED)

        def run() -> None:
            if history().checkerboard < 0:  # a graph's first frame runs whatever is due
                return
            for unit, texture in ((6, color), (5, distance), (CLOUD_DEPTH_UNIT, depth)):
                texture.use(unit)
            color.bind_to_image(0, read=False, write=True)
            distance.bind_to_image(1, read=False, write=True)
            upsampled.bind_to_image(2, read=False, write=True)
            self._place(self._between, history())
            self._between.run_over(color.width, _lanes_down(color.height, history()))

        return run

    def _place(self, program: Compute, history: History) -> None:
        history.give(program)
        # A ray without others beside it, from earlier frames, stands for its whole block. In a picture that stands
        # still each pixel will have its own; of a coarse one it is the mean of several, which filters enough.
        wide = {NONE: 0.8, STILL: 0.0}.get(history.mode, 0.3) * self._picture.block_px
        program.set("u_width", max(1.0, wide))

    def _bind_classify(
        self, io: PassIO, history: Callable[[], History], bind_clouds: Callable[[], None]
    ) -> Callable[[], None]:
        color, distance, depth = io.texture(RAYS), io.texture(DISTANCE), io.texture(self._picture.depth)
        flags, tiles = io.buffer(_FLAGS), io.buffer(_TILES)
        across = -(-color.width // TILE[0])

        def run() -> None:
            bind_clouds()
            depth.use(CLOUD_DEPTH_UNIT)
            color.bind_to_image(0, read=False, write=True)
            distance.bind_to_image(1, read=False, write=True)
            flags.bind_to_storage_buffer(FLAG_BUFFER)
            down = -(-_lanes_down(color.height, history()) // TILE[1])
            self._place(self._classify, history())
            self._classify.run(across, down)
            self._gpu.barrier()
            tiles.bind_to_storage_buffer(1)
            self._list.set("u_tiles", (across, down))
            self._list.run()

        return run

    def _bind_march(
        self, io: PassIO, history: Callable[[], History], bind_clouds: Callable[[], None]
    ) -> Callable[[], None]:
        color, distance, depth = io.texture(RAYS), io.texture(DISTANCE), io.texture(self._picture.depth)
        tiles, sun = io.buffer(_TILES), io.texture(SUN)
        bind = bind_contracts(self._world, io, but=self._system)

        def run() -> None:
            bind()
            bind_clouds()
            depth.use(CLOUD_DEPTH_UNIT)
            color.bind_to_image(0, read=False, write=True)
            distance.bind_to_image(1, read=False, write=True)
            sun.use(CLOUD_SUN_UNIT)
            tiles.bind_to_storage_buffer(TILE_BUFFER)
            for cirrus, program in enumerate((self._no_cirrus, self._march)):
                self._place(program, history())
                program.set("u_cirrus", cirrus)
                program.run_indirect(tiles, 16 * cirrus)

        return run

    def _bind_debug(
        self, io: PassIO, history: Callable[[], History], bind_clouds: Callable[[], None]
    ) -> Callable[[], None]:
        classes, steps = io.texture("debug.cloud_tiles"), io.texture("debug.cloud_steps")
        depth, flags, sun = io.texture(self._picture.depth), io.buffer(_FLAGS), io.texture(SUN)
        bind = bind_contracts(self._world, io, but=self._system)
        if self._debug is None:
            self._debug = self._program("clouds/debug.comp")
            self._programs.add(self._debug)
            self._steps.give(self._debug)

        def run() -> None:
            program = self._debug
            assert program is not None
            bind()
            bind_clouds()
            depth.use(CLOUD_DEPTH_UNIT)
            sun.use(CLOUD_SUN_UNIT)
            classes.bind_to_image(0, read=False, write=True)
            steps.bind_to_image(1, read=False, write=True)
            flags.bind_to_storage_buffer(FLAG_BUFFER)
            self._place(program, history())
            program.run_over(classes.width, _lanes_down(classes.height, history()))

        return run


def _lanes_down(rows: int, history: History) -> int:
    """Of the march, for so many rows of blocks."""
    return rows if history.checkerboard < 0 else -(-rows // 2)
