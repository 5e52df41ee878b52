"""AtmosphereSystem: owns the air's tables and provides the shader contracts air and sky from them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np

from ...components import Atmosphere, Planet, Shape
from ...engine.frame import Frame, ViewInfo
from ...engine.frame.contracts import provide_contracts, withdraw_contracts
from ...engine.frame.unseen import Unseen
from ...engine.gpu.bindings import AIR_BLOCK, AIR_EXTINCTION_UNIT, AIR_FIRST_UNIT, AIR_SECOND_UNIT, AIR_VIEW_BLOCK
from ...engine.graph import GraphBuilder, PassIO, TextureSpec
from ...engine.settings import SettingError, revision, with_overrides
from ...engine.system import Setup, System
from .block import AirBlock, air_block
from .job import TableJob
from .model import AirModel
from .sizes import paper_sizes, table_sizes, view_sizes
from .views import AirViewBlock, sun_at, view_block

__all__ = ["AtmosphereSystem"]

_CONTRACTS = {
    "ours": {"air": "atmosphere/air.glsl", "sky": "atmosphere/sky.glsl", "air_point": "atmosphere/air_point.glsl"},
    "paper": {"air": "atmosphere/paper/air.glsl", "sky": "atmosphere/paper/sky.glsl"},
}
_HURRY_S = 0.25
"""Time a frame for the tables while nobody looks."""
_VIEW_TABLES = ("atmosphere.first", "atmosphere.second", "atmosphere.extinction")


class _View:
    """The air of one view: what its tables are to show, and what they show."""

    def __init__(self) -> None:
        self.wanted: tuple[Any, ...] = ()
        self.filled: tuple[Any, ...] = ()
        self.block = AirViewBlock(
            camera=(0.0, 1.0, 0.0, 0.0),
            span=(0.0, 0.0, 0.0, 0.0),
            shape=(1.0, 1.0, 0.1, 0.0),
            sun_side=(1.0, 0.0, 0.0, 0.0),
            size=(0, 0, 0, 0),
        )
        self.seen = True


class AtmosphereSystem(System):
    """The air of one planet. Needs Planet and Atmosphere.

    Passes: ``atmosphere.tables`` computes what holds for all cameras, a few milliseconds a frame, after the air has
    changed; ``atmosphere.view`` fills the tables of one camera when its altitude or the sun's height has changed.
    Publishes the world resource ``air_top_m``: how high the air reaches.
    """

    name: ClassVar[str] = "atmosphere"
    needs: ClassVar[tuple[type, ...]] = (Planet, Atmosphere)

    def __init__(self) -> None:
        self._world: Any = None

    def setup(self, setup: Setup) -> None:
        self._gpu, self._world, self._settings = setup.gpu, setup.world, setup.settings
        self._sizes = view_sizes(setup.settings)
        self._model_ubo = setup.gpu.uniform_block(AirBlock, AIR_BLOCK, "air_model")
        self._view_ubo = setup.gpu.uniform_block(AirViewBlock, AIR_VIEW_BLOCK, "air_view")
        self._budget_s = 1e-3 * float(setup.settings["atmosphere.budget_ms"])
        self._hurry = False
        self._unseen = Unseen(Atmosphere, Planet)
        self._stamp: tuple[Any, ...] = ()
        self._method = ""
        self._job: TableJob | None = None
        self._fills: tuple[Any, ...] = ()
        # Now, not with the first frame: the systems that are set up next compile shaders with the contracts in them.
        self._use_method(with_overrides(setup.world.get(setup.planet, Atmosphere), "atmosphere", setup.settings).method)
        provide_contracts(setup.world, self.name, self)

    def release(self) -> None:
        self._gpu.gpu.shaders.withdraw(self.name)
        withdraw_contracts(self._world, self.name)
        self._world.resources.pop("air_top_m", None)

    def _use_method(self, method: str) -> TableJob:
        """Tables, programs and contracts of a method, in place of those of another."""
        if method == self._method and self._job is not None:
            return self._job
        if self._job is not None:
            self._job.release()
            for program in self._fills:
                self._gpu.free(program)
        shaders = self._gpu.gpu.shaders
        shaders.withdraw(self.name)
        for contract, file in _CONTRACTS[method].items():
            shaders.provide(contract, file, owner=self.name)
        self._fills = ()
        if method == "paper":
            self._job = TableJob(self._gpu, paper_sizes(self._settings), self._model_ubo)
        else:
            tables = table_sizes(self._settings)
            self._job = TableJob(self._gpu, tables, self._model_ubo)
            light = self._gpu.compute("atmosphere/view_fill.comp", {"AIR_DEGREE": tables.degree})
            self._fills = (self._gpu.compute("atmosphere/view_depth.comp"), light)
        self._method = method
        self.structure += 1
        return self._job

    # -- contracts ---------------------------------------------------------------------------------------------------

    def contract_reads(self) -> tuple[str, ...]:
        """See engine.contracts.ContractSource."""
        return () if self._method == "paper" else _VIEW_TABLES

    def bind_contract(self, io: PassIO) -> Callable[[], None]:
        """See engine.contracts.ContractSource."""
        job = self._job
        assert job is not None
        if self._method == "paper":
            return job.bind
        first, second, extinction = (io.texture(name) for name in _VIEW_TABLES)

        def run() -> None:
            first.use(AIR_FIRST_UNIT)
            second.use(AIR_SECOND_UNIT)
            extinction.use(AIR_EXTINCTION_UNIT)
            job.bind()

        return run

    # -- frame -------------------------------------------------------------------------------------------------------

    def update(self, frame: Frame) -> None:
        # Things in space are lit through the air of a planet that isn't in the picture.
        if self._unseen.rests(frame) and not frame.world.query(Shape):
            self._view_ubo.bind()
            self._model_ubo.bind()
            return
        self._hurry = frame.settling
        job = self._refresh(frame.world, frame.planet, frame.settings, frame.sun)
        model = job.shown
        view = frame.view.state(self, _View)
        camera = frame.camera
        distance = camera.distance_m
        cosine, sine, side = sun_at(camera.direction, frame.sun.direction)
        pixel = frame.pixel_rad
        view.seen = distance <= 2.0 * model.top_radius_m or 2.0 * model.top_radius_m / distance > pixel
        view.block = view_block(model, distance - model.radius_m, cosine, sine, side, self._sizes)
        view.wanted = self._state(view, job)
        # The air that is shown may be the one from before.
        top_m = max(model.thickness_m, self._wanted_top_m)
        for name, value in (("air_top_m", top_m), ("air_generation", job.generation)):
            if frame.world.try_resource(name) != value:
                frame.world.set_resource(name, value)
        self._view_ubo.write(view.block)
        self._view_ubo.bind()
        self._model_ubo.bind()

    def _refresh(self, world: Any, planet: int, settings: Mapping[str, Any], sun: Any) -> TableJob:
        air, body = world.get(planet, Atmosphere), world.get(planet, Planet)
        light = (sun.angular_radius_rad, *sun.irradiance)
        job = self._job
        assert job is not None
        stamp = (id(air), revision(air), revision(body, "radius_m"), light)
        if (*stamp, job.sources) == self._stamp:
            return job
        try:
            air = with_overrides(air, "atmosphere", settings)
            model = AirModel.from_components(body, air, sun.angular_radius_rad)
        except SettingError:
            # Said once; the frames after it show the air from before, if there is any.
            if job.started:
                self._stamp = (*stamp, job.sources)
            raise
        job = self._use_method(air.method)
        self._stamp = (*stamp, job.sources)
        self._wanted_top_m = model.thickness_m
        job.want(model, air_block(model, air, sun.irradiance))
        return job

    def _state(self, view: _View, job: TableJob) -> tuple[Any, ...]:
        """What a view's tables depend on. Turning about the zenith and moving under an equally high sun change nothing:
        the rounding in float64 that both leave is taken off here."""
        altitude, cosine = view.block.camera[:2]
        camera = np.float32(round(altitude, 6)), np.float32(round(cosine, 9))
        return (job.generation, *camera, *(program.linked.key for program in self._fills))

    def settled(self) -> bool:
        return self._job is None or self._job.done

    def progress(self) -> float:
        """Share of the tables that is done, 0..1."""
        return 0.0 if self._job is None else self._job.share

    def refining(self) -> str:
        return "" if self._job is None or self._job.done else f"air {100.0 * self._job.share:.0f} %"

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        job = self._job
        assert job is not None, "update comes before declare"
        builder.add_pass(
            "atmosphere.tables",
            kind="compute",
            system=self.name,
            bind=lambda io: lambda: self._run_tables(job),
            side_effect=True,
            when=lambda: not job.done,
            help="what holds for all cameras, in slices: optical depth to space and light scattered more than once",
        )
        if self._method == "paper":
            return
        own = view.view.state(self, _View)
        own.filled = ()
        light, depth = self._sizes.texels, self._sizes.extinction_texels
        builder.add_pass(
            "atmosphere.view",
            kind="compute",
            system=self.name,
            bind=lambda io: self._bind_view(io, own, job),
            after=("atmosphere.tables",),
            creates=(
                TextureSpec(
                    _VIEW_TABLES[0],
                    "rgba32f",
                    light,
                    "persistent",
                    filter="linear",
                    help="mean source, gas and all orders",
                ),
                TextureSpec(
                    _VIEW_TABLES[1],
                    "rgba32f",
                    light,
                    "persistent",
                    filter="linear",
                    help="mean source of haze, first order",
                ),
                TextureSpec(_VIEW_TABLES[2], "rgba32f", depth, "persistent", help="mean extinction"),
            ),
            when=lambda: own.seen and (own.filled != own.wanted or not job.done),
            help="the air around one camera, when its altitude or the sun's height has changed",
        )

    def _run_tables(self, job: TableJob) -> None:
        job.work(_HURRY_S if self._hurry else self._budget_s)

    def _bind_view(self, io: PassIO, view: _View, job: TableJob) -> Callable[[], None]:
        first, second, extinction = (io.texture(name) for name in _VIEW_TABLES)
        fill_depth, fill_light = self._fills
        view.filled = ()

        def run() -> None:
            if job.generation != view.wanted[0]:
                # The tables have been finished in this very frame, maybe of another air.
                altitude, cosine, sine, _ = view.block.camera
                side = np.asarray(view.block.sun_side[:3])
                view.block = view_block(job.shown, altitude, cosine, sine, side, self._sizes)
                self._view_ubo.write(view.block)
            wanted = self._state(view, job)
            if wanted == view.filled:
                return
            job.bind()
            extinction.bind_to_image(0, read=False, write=True)
            fill_depth.run_over(2 * self._sizes.rows)
            first.bind_to_image(0, read=False, write=True)
            second.bind_to_image(1, read=False, write=True)
            fill_light.run_over(*self._sizes.texels[:2])
            view.filled = wanted

        return run
