"""AirMethod: the tables of the air by one method, and the shader contracts that read them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import ClassVar, NamedTuple

import numpy as np

from ...engine.blocks.bindings import AIR_EXTINCTION_UNIT, AIR_FIRST_UNIT, AIR_SECOND_UNIT, AIR_VIEW_BLOCK
from ...engine.frame import Frame, View, ViewInfo, ViewParts
from ...engine.gpu import Compute, GpuScope, UniformBlock
from ...engine.graph import GraphBuilder, PassIO, TextureSpec
from ...engine.methods import Method
from ...engine.settings import Settings
from .job import MakesTables, TableJob
from .sizes import paper_sizes, table_sizes, view_sizes
from .views import AirViewBlock, sun_at, view_block

__all__ = ["AirMethod", "OurAir", "PaperAir"]

_AT_ONCE_S = 0.25
"""Time a frame for the tables while nobody looks."""
_CAMERA = "atmosphere.camera"
"""A view's uniform block, lent to the graph."""
_VIEW_TABLES = ("atmosphere.first", "atmosphere.second", "atmosphere.extinction")


class _TablesKey(NamedTuple):
    """What a view's tables depend on. air: generation of those for all cameras; shaders: keys of what fills
    them."""

    air: int
    altitude_m: np.float32
    sun_mu: np.float32
    shaders: tuple[object, ...]


class _View(ViewParts):
    """The air of one view: what its tables are to show, and what they show."""

    def __init__(self, of: GpuScope) -> None:
        super().__init__(of)
        self.ubo = self.gpu.uniform_block(AirViewBlock, AIR_VIEW_BLOCK)
        self.wanted: _TablesKey | None = None
        self.filled: _TablesKey | None = None
        self.block: AirViewBlock
        self.seen = True


class AirMethod(Method):
    """One of Atmosphere.method. model: the uniform block air_model. sizes: of its tables."""

    reads: ClassVar[tuple[str, ...]] = ()
    """Resources of the graph that its contracts sample."""

    def __init__(self, gpu: GpuScope, settings: Settings, model: UniformBlock, sizes: MakesTables) -> None:
        super().__init__(gpu)
        self.job = TableJob(gpu, sizes, model)
        self._sizes = view_sizes(settings)
        self.budget_s = 1e-3 * float(settings["atmosphere.budget_ms"])
        self._fills: tuple[Compute, ...] = ()

    def bind_contract(self, io: PassIO) -> Callable[[], None]:
        """See engine.frame.contracts.ContractSource."""
        return self.job.bind

    def _of(self, view: View) -> _View:
        return view.state(self, lambda: _View(self.gpu))

    def update(self, frame: Frame) -> None:
        model, view, camera = self.job.shown, self._of(frame.view), frame.camera
        distance = camera.distance_m
        cosine, sine, side = sun_at(camera.direction, frame.sun.direction)
        pixel = frame.pixel_rad
        view.seen = distance <= 2.0 * model.top_radius_m or 2.0 * model.top_radius_m / distance > pixel
        view.block = view_block(model, distance - model.radius_m, cosine, sine, side, self._sizes)
        view.wanted = self._state(view)
        view.ubo.write(view.block)

    def _state(self, view: _View) -> _TablesKey:
        """What a view's tables depend on. Turning about the zenith and moving under an equally high sun change nothing:
        the rounding in float64 that both leave is taken off here."""
        shown = view.block.camera
        camera = np.float32(round(shown.altitude_m, 6)), np.float32(round(shown.sun_mu, 9))
        return _TablesKey(self.job.generation, *camera, tuple(program.linked.key for program in self._fills))

    def settled(self, view: View) -> bool:
        return self.job.done

    def progress(self, view: View) -> float:
        return self.job.share

    def refining(self, view: View) -> str:
        return "" if self.job.done else f"air {100.0 * self.job.share:.0f} %"

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        builder.add_pass(
            "atmosphere.tables",
            kind="compute",
            system=self.gpu.owner,
            bind=lambda io: lambda: self.job.work(_AT_ONCE_S if view.view.frame.settling else self.budget_s),
            side_effect=True,
            when=lambda: not self.job.done,
            help="what holds for all cameras, in slices: optical depth to space and light scattered more than once",
        )


class PaperAir(AirMethod):
    """As Bruneton prints it: one set of tables for all cameras."""

    contracts: ClassVar[Mapping[str, str]] = {"air": "atmosphere/paper/air.glsl", "sky": "atmosphere/paper/sky.glsl"}

    def __init__(self, gpu: GpuScope, settings: Settings, model: UniformBlock) -> None:
        super().__init__(gpu, settings, model, paper_sizes(settings))


class OurAir(AirMethod):
    """Tables for all cameras, and from them those of each view."""

    contracts: ClassVar[Mapping[str, str]] = {
        "air": "atmosphere/air.glsl",
        "sky": "atmosphere/sky.glsl",
        "air_point": "atmosphere/air_point.glsl",
    }
    reads: ClassVar[tuple[str, ...]] = (_CAMERA, *_VIEW_TABLES)

    def __init__(self, gpu: GpuScope, settings: Settings, model: UniformBlock) -> None:
        tables = table_sizes(settings)
        super().__init__(gpu, settings, model, tables)
        light = gpu.compute("atmosphere/view_fill.comp", {"AIR_DEGREE": tables.degree})
        self._fills = (gpu.compute("atmosphere/view_depth.comp"), light)

    def bind_contract(self, io: PassIO) -> Callable[[], None]:
        first, second, extinction = (io.texture(name) for name in _VIEW_TABLES)
        camera = io.imported(_CAMERA)

        def run() -> None:
            camera.value.bind_to_uniform_block(AIR_VIEW_BLOCK)
            first.use(AIR_FIRST_UNIT)
            second.use(AIR_SECOND_UNIT)
            extinction.use(AIR_EXTINCTION_UNIT)
            self.job.bind()

        return run

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        super().declare(builder, view)
        own = self._of(view.view)
        own.filled = None
        builder.import_(_CAMERA, "buffer", help="the camera in its air", lent=own.ubo.buffer)
        light, depth = self._sizes.texels, self._sizes.extinction_texels
        builder.add_pass(
            "atmosphere.view",
            kind="compute",
            system=self.gpu.owner,
            bind=lambda io: self._bind_view(io, own),
            reads=(_CAMERA,),
            after=("atmosphere.tables",),
            creates=(
                TextureSpec(
                    _VIEW_TABLES[0],
                    "rgba32f",
                    light,
                    "persistent",
                    layers=self._sizes.layers,
                    filter="linear",
                    help="mean source, gas and all orders",
                ),
                TextureSpec(
                    _VIEW_TABLES[1],
                    "rgba32f",
                    light,
                    "persistent",
                    layers=self._sizes.layers,
                    filter="linear",
                    help="mean source of haze, first order",
                ),
                TextureSpec(_VIEW_TABLES[2], "rgba32f", depth, "persistent", help="mean extinction"),
            ),
            when=lambda: own.seen and (own.filled != own.wanted or not self.job.done),
            help="the air around one camera, when its altitude or the sun's height has changed",
        )

    def _bind_view(self, io: PassIO, view: _View) -> Callable[[], None]:
        first, second, extinction = (io.texture(name) for name in _VIEW_TABLES)
        fill_depth, fill_light = self._fills
        job = self.job
        view.filled = None

        def run() -> None:
            if view.wanted is None or job.generation != view.wanted.air:
                # The tables have been finished in this very frame, maybe of another air.
                was, side = view.block.camera, np.asarray(view.block.sun_side)
                view.block = view_block(job.shown, was.altitude_m, was.sun_mu, was.sun_sine, side, self._sizes)
                view.ubo.write(view.block)
            wanted = self._state(view)
            if wanted == view.filled:
                return
            job.bind()
            view.ubo.bind()
            extinction.bind_to_image(0, read=False, write=True)
            fill_depth.run_over(2 * self._sizes.rows)
            self.gpu.barrier()
            first.bind_to_image(0, read=False, write=True)
            second.bind_to_image(1, read=False, write=True)
            extinction.bind_to_image(2, read=True, write=False)
            fill_light.run_over(*self._sizes.texels)
            view.filled = wanted

        return run
