"""CloudMethods: the clouds' system by either method, ours or as printed, exchanged while it runs."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

from ...components import Atmosphere, CloudLayer, Clouds, Ocean, Planet
from ...engine.frame import Frame, View, ViewInfo
from ...engine.frame.unseen import Unseen
from ...engine.graph import GraphBuilder, PassIO
from ...engine.settings import revision, with_overrides
from ...engine.system import Setup
from .model import CloudModel
from .paper import PaperClouds
from .system import CloudSystem

__all__ = ["CloudMethods"]

_YEARS = {"paper_2018": 2018, "paper_2019": 2019}


class CloudMethods(CloudSystem):
    """What `Clouds.method` says: CloudSystem itself, or PaperClouds in its place. Each has a scope of its own for its
    GL objects, so that nothing of the other is kept."""

    def setup(self, setup: Setup) -> None:
        self._setup, self._method = setup, ""
        self._unseen = Unseen(Clouds, CloudLayer, Planet, Atmosphere, Ocean)
        self._paper: PaperClouds | None = None
        self._scope: Any = None
        self._checked: tuple[Any, ...] = ()
        self._good = False
        self._use(setup.world.get(setup.planet, Clouds), setup.settings)

    def _use(self, component: Clouds, settings: Mapping[str, Any]) -> None:
        method = with_overrides(component, "clouds", settings).method
        if method == self._method:
            return
        if self._method:
            self._end()
        self._method = method
        self._scope = self._setup.gpu.beside(self.name)
        own = dataclasses.replace(self._setup, gpu=self._scope, settings=settings)
        self._paper = None
        if method in _YEARS:
            self._paper = PaperClouds(self.name, _YEARS[method])
            self._paper.setup(own)
        else:
            super().setup(own)
        self.structure += 1

    def _end(self) -> None:
        self._setup.views.forget(self)
        if self._paper is not None:
            self._setup.views.forget(self._paper)
            self._paper.release()
        else:
            super().release()
        self._scope.release()

    def release(self) -> None:
        self._end()
        self._method = ""

    def contract_reads(self) -> tuple[str, ...]:
        """See engine.contracts.ContractSource."""
        return super().contract_reads() if self._paper is None else self._paper.contract_reads()

    def bind_contract(self, io: PassIO) -> Callable[[], None]:
        """See engine.contracts.ContractSource."""
        return super().bind_contract(io) if self._paper is None else self._paper.bind_contract(io)

    def update(self, frame: Frame) -> None:
        if self._unseen.rests(frame):
            return
        self._use(frame.world.get(frame.planet, Clouds), frame.settings)
        self._check(frame)
        if self._paper is None:
            self.moving = None
            super().update(frame)
            return
        self._paper.update(frame, refresh=self._good)
        self.moving = not self._paper.settled()

    def _check(self, frame: Frame) -> None:
        """Clouds that cannot be are told of once, by a SettingError; frames after it show those from before."""
        component, planet = frame.world.get(frame.planet, Clouds), frame.world.get(frame.planet, Planet)
        air = frame.world.try_get(frame.planet, Atmosphere)
        stamp = (id(component), revision(component), revision(planet, "radius_m"), id(air), air and revision(air))
        if stamp == self._checked:
            return
        self._checked, self._good = stamp, False
        CloudModel.from_components(
            planet,
            with_overrides(component, "clouds", frame.settings),
            None if air is None else with_overrides(air, "atmosphere", frame.settings),
        )
        self._good = True

    def _refresh(self, frame: Frame) -> None:
        if self._good:
            super()._refresh(frame)

    def structure_of(self, view: View) -> object:
        return super().structure_of(view) if self._paper is None else (self.structure, self._paper.seen_in(view).seen)

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        (super() if self._paper is None else self._paper).declare(builder, view)

    def settled(self) -> bool:
        """Whether nothing streams, refines or is still being made."""
        return super().settled() if self._paper is None else self._paper.settled()

    def refining(self) -> str:
        """See System.refining."""
        return super().refining() if self._paper is None else self._paper.refining()

    def progress(self) -> float:
        """How much of that is done."""
        return super().progress() if self._paper is None else self._paper.progress()
