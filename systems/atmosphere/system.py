"""AtmosphereSystem: owns the air's tables and provides the shader contracts air and sky from them."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np

from ...components import Atmosphere, Planet
from ...engine.contracts import provide_contracts, withdraw_contracts
from ...engine.graph import GraphBuilder, PassIO, TextureSpec
from ...engine.settings import revision, with_overrides
from ...engine.system import Frame, Setup, System, ViewInfo
from .block import AIR_BINDING, AirBlock, air_block
from .job import TableJob
from .model import AirModel
from .sizes import table_sizes, view_sizes
from .views import VIEW_BINDING, AirViewBlock, sun_at, view_block

__all__ = ["AtmosphereSystem"]

_FIRST_UNIT, _SECOND_UNIT, _EXTINCTION_UNIT = 10, 11, 12
_VIEW_TABLES = ("atmosphere.first", "atmosphere.second", "atmosphere.extinction")


class _View:
    """The air of one view: what its tables are to show, and what they show."""

    def __init__(self) -> None:
        self.wanted: tuple[Any, ...] = ()
        self.filled: tuple[Any, ...] = ()
        self.block = AirViewBlock()
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
        self._views: dict[int, _View] = {}
        self._world: Any = None

    def setup(self, setup: Setup) -> None:
        self._gpu, self._world = setup.gpu, setup.world
        self._sizes = view_sizes(setup.settings)
        tables = table_sizes(setup.settings)
        shaders = setup.gpu.gpu.shaders
        self._model_ubo = setup.gpu.uniform_block(AirBlock, AIR_BINDING, "air_model")
        self._view_ubo = setup.gpu.uniform_block(AirViewBlock, VIEW_BINDING, "air_view")
        self._job = TableJob(setup.gpu, tables, self._model_ubo)
        self._fill = setup.gpu.compute("atmosphere/view_fill.comp", {"AIR_DEGREE": tables.degree})
        self._fill_depth = setup.gpu.compute("atmosphere/view_depth.comp")
        self._budget_s = 1e-3 * float(setup.settings["atmosphere.budget_ms"])
        self._hurry = False
        self._stamp: tuple[Any, ...] = ()
        self._model: AirModel | None = None
        for contract in ("air", "sky"):
            shaders.provide(contract, f"atmosphere/{contract}.glsl", owner=self.name)
        provide_contracts(setup.world, self.name, self)

    def release(self) -> None:
        self._views.clear()
        self._gpu.gpu.shaders.withdraw(self.name)
        withdraw_contracts(self._world, self.name)
        self._world.resources.pop("air_top_m", None)

    # -- contracts ---------------------------------------------------------------------------------------------------

    def contract_reads(self) -> tuple[str, ...]:
        """See engine.contracts.ContractSource."""
        return _VIEW_TABLES

    def bind_contract(self, io: PassIO) -> Callable[[], None]:
        """See engine.contracts.ContractSource."""
        first, second, extinction = (io.texture(name) for name in _VIEW_TABLES)

        def run() -> None:
            first.use(_FIRST_UNIT)
            second.use(_SECOND_UNIT)
            extinction.use(_EXTINCTION_UNIT)
            self._job.bind()

        return run

    # -- frame -------------------------------------------------------------------------------------------------------

    def update(self, frame: Frame) -> None:
        self._hurry = frame.settling
        self._refresh(frame.world, frame.planet, frame.settings, frame.sun)
        model = self._job.shown
        view = self._views.setdefault(frame.view_index, _View())
        distance = float(np.linalg.norm(frame.camera.position_m))
        up = frame.camera.position_m / distance
        cosine, sine, side = sun_at(up, frame.sun.direction)
        camera = frame.camera
        pixel = (camera.tan_top - camera.tan_bottom) / frame.size[1]
        view.seen = distance <= 2.0 * model.top_radius_m or 2.0 * model.top_radius_m / distance > pixel
        view.block = view_block(model, distance - model.radius_m, cosine, sine, side, self._sizes)
        # What the tables depend on; turning about the zenith and moving under an equally high sun changes nothing.
        view.wanted = (self._job.generation, view.block.camera)
        self._view_ubo.write(view.block)
        self._view_ubo.bind()
        self._model_ubo.bind()

    def _refresh(self, world: Any, planet: int, settings: Mapping[str, Any], sun: Any) -> None:
        air, body = world.get(planet, Atmosphere), world.get(planet, Planet)
        light = (sun.angular_radius_rad, *sun.irradiance)
        stamp = (id(air), revision(air), revision(body, "radius_m"), light)
        if stamp == self._stamp:
            return
        self._stamp = stamp
        air = with_overrides(air, "atmosphere", settings)
        model = AirModel.from_components(body, air, sun.angular_radius_rad)
        block = air_block(model, air, sun.irradiance)
        self._job.want(model, block)
        world.set_resource("air_top_m", model.thickness_m)

    def settled(self) -> bool:
        return self._job.done

    def progress(self) -> float:
        """Share of the tables that is done, 0..1."""
        return self._job.share

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        builder.add_pass(
            "atmosphere.tables",
            kind="compute",
            system=self.name,
            bind=lambda io: self._run_tables,
            side_effect=True,
            when=lambda: not self._job.done,
            help="what holds for all cameras, in slices: optical depth to space and light scattered more than once",
        )
        own = self._views.setdefault(view.index, _View())
        own.filled = ()
        columns, rows, slices = self._sizes.texels
        light = (columns, rows, slices)
        builder.add_pass(
            "atmosphere.view",
            kind="compute",
            system=self.name,
            bind=lambda io: self._bind_view(io, own),
            after=("atmosphere.tables",),
            creates=(
                TextureSpec(
                    _VIEW_TABLES[0], "rgba32f", light, "persistent", help="mean source of gas and of all orders"
                ),
                TextureSpec(_VIEW_TABLES[1], "rgba32f", light, "persistent", help="mean source of haze, first order"),
                TextureSpec(
                    _VIEW_TABLES[2], "rgba32f", self._sizes.extinction_texels, "persistent", help="mean extinction"
                ),
            ),
            when=lambda: own.seen and (own.filled != own.wanted or not self._job.done),
            help="the air around one camera, when its altitude or the sun's height has changed",
        )

    def _run_tables(self) -> None:
        started = time.perf_counter()
        budget = 0.25 if self._hurry else self._budget_s
        self._job.work(lambda: budget - (time.perf_counter() - started))

    def _bind_view(self, io: PassIO, view: _View) -> Callable[[], None]:
        images = [io.texture(name) for name in _VIEW_TABLES]
        view.filled = ()

        def run() -> None:
            wanted = (self._job.generation, view.block.camera)
            if wanted == view.filled:
                return
            if self._job.generation != view.wanted[0]:
                # The tables have been finished in this very frame, maybe of another air.
                camera = view.block.camera
                model = self._job.shown
                side = np.asarray(view.block.sun_side[:3])
                altitude = camera[0]
                view.block = view_block(model, altitude, camera[1], camera[2], side, self._sizes)
                self._view_ubo.write(view.block)
            self._job.bind()
            images[2].bind_to_image(0, read=False, write=True)
            self._fill_depth.run_over(2 * self._sizes.rows)
            for unit in (0, 1):
                images[unit].bind_to_image(unit, read=False, write=True)
            self._fill.run_over(*self._sizes.texels[:2])
            view.filled = wanted

        return run
