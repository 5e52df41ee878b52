"""LabelPasses: textures with what programs want to know of each pixel; a graph in which nobody reads one culls it."""

from __future__ import annotations

from collections.abc import Callable

from ...engine.blocks.bindings import DEPTH_UNIT, NORMAL_UNIT, SURFACE_UNIT
from ...engine.frame.contracts import bind_contracts, contract_reads
from ...engine.frame.labels import LABELS
from ...engine.gpu import Fullscreen, GpuScope
from ...engine.graph import GraphBuilder, PassIO, TextureSpec
from ...engine.world import World

__all__ = ["LabelPasses"]

_MOTION, _SHADOW = "props.motion", "props.shadow"
_ALBEDO, _INSTANCE = LABELS


class LabelPasses:
    """Part of GBufferSystem. Ground, water, props and trees write what they know into outputs.albedo and
    outputs.instance."""

    def __init__(self, gpu: GpuScope, world: World) -> None:
        self._gpu, self._world = gpu, world
        self._programs: dict[tuple[str, ...], Fullscreen] = {}
        self._write_all = gpu.state(depth_test=False, cull=None, blend=None)

    def declare(self, builder: GraphBuilder, system: str) -> None:
        """The passes of one view."""
        builder.add_pass(
            "outputs.moved",
            bind=self._bind_moved,
            system=system,
            reads=("gbuffer.depth", "gbuffer.surface"),
            reads_optional=(_MOTION,),
            help="where what is seen was a frame ago",
            creates=(
                TextureSpec("outputs.moved", "rgba32f", help="m from the camera as it is now, planet axes; w: 1 or 0"),
            ),
        )
        builder.add_pass(
            "outputs.sunlit",
            bind=self._bind_sunlit,
            system=system,
            reads=("gbuffer.depth", "gbuffer.normal", "gbuffer.surface", *contract_reads(self._world)),
            reads_optional=(_SHADOW,),
            help="what of the sun reaches a pixel's surface",
            creates=(TextureSpec("outputs.sunlit", "r16f", help="share of the sun's disc"),),
        )
        builder.add_pass(
            "outputs.albedo",
            bind=self._bind_albedo,
            system=system,
            reads=("gbuffer.attributes", "gbuffer.surface"),
            help="albedo and material of props and trees",
            creates=(TextureSpec(_ALBEDO, "rgba16f", help="share of light that is thrown back; w: material's number"),),
        )
        builder.add_pass(
            "outputs.instance",
            bind=self._bind_nothing,
            system=system,
            help="no thing is seen yet",
            creates=(TextureSpec(_INSTANCE, "r32ui", help="numbers of props and trees, 0 elsewhere"),),
        )

    def _program(self, file: str, *flags: str) -> Fullscreen:
        """Made when somebody asks."""
        if (file, *flags) not in self._programs:
            self._programs[file, *flags] = self._gpu.fullscreen(file, defines=dict.fromkeys(flags, 1))
        return self._programs[file, *flags]

    def _bind_moved(self, io: PassIO) -> Callable[[], None]:
        moves = io.has(_MOTION)
        names = ("gbuffer.depth", "gbuffer.surface", *((_MOTION,) if moves else ()))
        program = self._program("outputs/moved.frag", *(("MOTION",) if moves else ()))
        return self._drawing(io, "outputs.moved", program, dict(enumerate(names)))

    def _bind_sunlit(self, io: PassIO) -> Callable[[], None]:
        shadowed = io.has(_SHADOW)
        units = {DEPTH_UNIT: "gbuffer.depth", NORMAL_UNIT: "gbuffer.normal", SURFACE_UNIT: "gbuffer.surface"}
        program = self._program("outputs/sunlit.frag", *(("PROP_SHADOWS",) if shadowed else ()))
        draw = self._drawing(io, "outputs.sunlit", program, units | ({4: _SHADOW} if shadowed else {}))
        bind_light = bind_contracts(self._world, io)

        def run() -> None:
            bind_light()
            draw()

        return run

    def _bind_albedo(self, io: PassIO) -> Callable[[], None]:
        program = self._program("outputs/albedo.frag")
        return self._drawing(io, _ALBEDO, program, {0: "gbuffer.attributes", 1: "gbuffer.surface"})

    def _drawing(self, io: PassIO, target: str, program: Fullscreen, units: dict[int, str]) -> Callable[[], None]:
        picture = io.framebuffer(colors=(target,))
        textures = [(unit, io.texture(name)) for unit, name in units.items()]

        def run() -> None:
            picture.use()
            self._write_all.apply()
            for unit, texture in textures:
                texture.use(unit)
            program.render()

        return run

    def _bind_nothing(self, io: PassIO) -> Callable[[], None]:
        picture = io.framebuffer(colors=(_INSTANCE,))

        def run() -> None:
            picture.use()
            self._write_all.apply()
            self._gpu.clear(picture, depth=0.0)

        return run
