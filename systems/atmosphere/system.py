"""AtmosphereSystem: owns the air's tables and provides the shader contracts air and sky from them."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar, NamedTuple

from ...components import Atmosphere, Planet, Shape
from ...engine.blocks.bindings import AIR_BLOCK, AIR_VIEW_BLOCK
from ...engine.frame import Frame, SunState, View, ViewInfo
from ...engine.frame.contracts import provide_contracts, withdraw_contracts
from ...engine.frame.published import AIR_GENERATION, AIR_TOP_M
from ...engine.frame.unseen import Unseen
from ...engine.graph import GraphBuilder, PassIO
from ...engine.methods import Methods
from ...engine.settings import PartRevision, SettingError, Settings, revision, with_overrides
from ...engine.system import Setup, System
from ...engine.wavelengths import carried_air, wavelengths_of
from ...engine.world import World
from .block import AirBlock, air_block
from .job import TableJob
from .methods import AirMethod, OurAir, PaperAir
from .model import AirModel
from .views import AirViewBlock

__all__ = ["AtmosphereSystem"]

_METHODS: dict[str, type[OurAir] | type[PaperAir]] = {"ours": OurAir, "paper": PaperAir}


class _SunKey(NamedTuple):
    angular_radius_rad: float
    irradiance: tuple[float, ...]


class _AirKey(NamedTuple):
    """What the air follows from. radius: revision of the planet's; shaders: what its tables are computed by."""

    air: PartRevision
    radius: int
    sun: _SunKey
    shaders: str


class AtmosphereSystem(System):
    """The air of one planet. Needs Planet and Atmosphere.

    Passes: ``atmosphere.tables`` computes what holds for all cameras, a few milliseconds a frame, after the air has
    changed; ``atmosphere.view`` fills the tables of one camera when its altitude or the sun's height has changed.
    Publishes the world resource ``air_top_m``: how high the air reaches.
    """

    name: ClassVar[str] = "atmosphere"
    needs: ClassVar[tuple[type, ...]] = (Planet, Atmosphere)

    def __init__(self) -> None:
        self._methods: Methods[AirMethod]

    def setup(self, setup: Setup) -> None:
        self._world, self._settings = setup.world, setup.settings
        self._methods = Methods(setup.gpu, setup.views)
        self._model_ubo = setup.gpu.uniform_block(AirBlock, AIR_BLOCK, "air_model")
        # Its text, for shaders; each view has a block of its own.
        setup.gpu.uniform_block(AirViewBlock, AIR_VIEW_BLOCK, "air_view")
        self._unseen = Unseen(Atmosphere, Planet)
        self._stamp: _AirKey | None = None
        # Now, not with the first frame: the systems that are set up next compile shaders with the contracts in them.
        self._use_method(with_overrides(setup.world.get(setup.planet, Atmosphere), "atmosphere", setup.settings).method)
        provide_contracts(setup.world, self.name, self)

    def release(self) -> None:
        self._methods.release()
        withdraw_contracts(self._world, self.name)
        self._world.remove_resource(AIR_TOP_M)

    @property
    def method(self) -> AirMethod:
        """What computes the air now."""
        return self._methods.now

    def _use_method(self, name: str) -> None:
        kind = _METHODS[name]
        self._methods.use(kind, lambda gpu: kind(gpu, self._settings, self._model_ubo))
        self.structure += self._methods.changed()

    # -- contracts ---------------------------------------------------------------------------------------------------

    def contract_reads(self) -> tuple[str, ...]:
        """See engine.frame.contracts.ContractSource."""
        return self.method.reads

    def bind_contract(self, io: PassIO) -> Callable[[], None]:
        """See engine.frame.contracts.ContractSource."""
        return self.method.bind_contract(io)

    # -- frame -------------------------------------------------------------------------------------------------------

    def update(self, frame: Frame) -> None:
        # Things in space are lit through the air of a planet that isn't in the picture.
        if self._unseen.rests(frame) and not frame.world.query(Shape):
            return
        job = self._refresh(frame.world, frame.planet, frame.settings, frame.sun)
        self.method.update(frame)
        # The air that is shown may be the one from before.
        top_m = max(job.shown.thickness_m, self._wanted_top_m)
        for name, value in ((AIR_TOP_M, top_m), (AIR_GENERATION, job.generation)):
            if frame.world.try_resource(name) != value:
                frame.world.set_resource(name, value)

    def _refresh(self, world: World, planet: int, settings: Settings, sun: SunState) -> TableJob:
        air, body = world.get(planet, Atmosphere), world.get(planet, Planet)
        job = self.method.job
        light = _SunKey(sun.angular_radius_rad, tuple(sun.irradiance))
        stamp = _AirKey(PartRevision.of(air), revision(body, "radius_m"), light, job.sources)
        if stamp == self._stamp:
            return job
        try:
            air = carried_air(with_overrides(air, "atmosphere", settings), wavelengths_of(settings))
            model = AirModel.from_components(body, air, sun.angular_radius_rad)
        except SettingError:
            # Said once; the frames after it show the air from before, if there is any.
            if job.started:
                self._stamp = stamp
            raise
        self._use_method(air.method)
        job = self.method.job
        self._stamp = stamp._replace(shaders=job.sources)  # of another method, maybe
        self._wanted_top_m = model.thickness_m
        job.want(model, air_block(model, air, sun.irradiance))
        return job

    def settled(self, view: View) -> bool:
        return self.method.settled(view)

    def progress(self, view: View) -> float:
        """Share of the tables that is done, 0..1."""
        return self.method.progress(view)

    def refining(self, view: View) -> str:
        return self.method.refining(view)

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        self.method.declare(builder, view)
