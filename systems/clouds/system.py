"""CloudSystem: the clouds of a planet by one of their methods, ours or as printed, exchanged while it runs."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import ClassVar, NamedTuple

from ...components import Atmosphere, CloudLayer, Clouds, Ocean, Planet
from ...engine.frame import Frame, View, ViewInfo
from ...engine.frame.contracts import provide_contracts, withdraw_contracts
from ...engine.frame.unseen import Unseen
from ...engine.graph import GraphBuilder, PassIO
from ...engine.methods import Methods
from ...engine.settings import PartRevision, Settings, revision, with_overrides
from ...engine.system import Setup, System
from .method import CloudMethod
from .model import CloudModel
from .ours import OurClouds
from .paper import PaperClouds, PaperClouds2018

__all__ = ["CloudSystem"]

_METHODS: dict[str, type[OurClouds] | type[PaperClouds]] = {
    "ours": OurClouds,
    "paper_2018": PaperClouds2018,
    "paper_2019": PaperClouds,
}


class _Checked(NamedTuple):
    """Which clouds were found to be possible or not. radius: revision of the planet's; air: around them."""

    clouds: PartRevision
    radius: int
    air: PartRevision | None


class CloudSystem(System):
    """The clouds of one planet. Needs Planet and Clouds."""

    name: ClassVar[str] = "clouds"
    needs: ClassVar[tuple[type, ...]] = (Planet, Clouds)

    def __init__(self) -> None:
        self._methods: Methods[CloudMethod]

    def setup(self, setup: Setup) -> None:
        self._setup = setup
        self._methods = Methods(setup.gpu, setup.views)
        self._unseen = Unseen(Clouds, CloudLayer, Planet, Atmosphere, Ocean)
        self._checked: _Checked | None = None
        self._good = self._shown = False
        self._use_method(setup.world.get(setup.planet, Clouds), setup.settings)
        provide_contracts(setup.world, self.name, self)

    def release(self) -> None:
        self._methods.release()
        withdraw_contracts(self._setup.world, self.name)

    @property
    def method(self) -> CloudMethod:
        """What draws the clouds now."""
        return self._methods.now

    def _use_method(self, component: Clouds, settings: Settings) -> None:
        kind = _METHODS[with_overrides(component, "clouds", settings).method]
        self._methods.use(kind, lambda gpu: kind(gpu, dataclasses.replace(self._setup, settings=settings)))

    def contract_reads(self) -> tuple[str, ...]:
        """See engine.frame.contracts.ContractSource."""
        return self.method.reads

    def bind_contract(self, io: PassIO) -> Callable[[], None]:
        """See engine.frame.contracts.ContractSource."""
        return self.method.bind_contract(io)

    def update(self, frame: Frame) -> None:
        if self._unseen.rests(frame):
            return
        self._check(frame)
        if self._good:
            self._use_method(frame.world.get(frame.planet, Clouds), frame.settings)
            self.method.refresh(frame)
            self._shown = True
        self.method.update(frame)
        self.moving = self.method.moving
        self.structure += self._methods.changed()

    def _check(self, frame: Frame) -> None:
        """Raises SettingError for clouds that cannot be: once where earlier valid clouds are still shown, otherwise in
        every frame."""
        component, planet = frame.world.get(frame.planet, Clouds), frame.world.get(frame.planet, Planet)
        air = frame.world.try_get(frame.planet, Atmosphere)
        above = None if air is None else PartRevision.of(air)
        stamp = _Checked(PartRevision.of(component), revision(planet, "radius_m"), above)
        if stamp == self._checked:
            return
        self._checked, self._good = stamp if self._shown else None, False
        CloudModel.from_components(
            planet,
            with_overrides(component, "clouds", frame.settings),
            None if air is None else with_overrides(air, "atmosphere", frame.settings),
        )
        self._checked, self._good = stamp, True

    def structure_of(self, view: View) -> object:
        return self.structure, self.method.seen_in(view)

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        self.method.declare(builder, view)

    def settled(self, view: View) -> bool:
        return self.method.settled(view)

    def refining(self, view: View) -> str:
        return self.method.refining(view)

    def progress(self, view: View) -> float:
        return self.method.progress(view)
