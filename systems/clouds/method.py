"""CloudMethod: how clouds get into the picture, and what shader contracts read of them."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import ClassVar, NamedTuple

from ...components import Clouds, Ocean, Planet, Wind
from ...engine.frame import Frame, View
from ...engine.gpu import GpuScope
from ...engine.graph import PassIO
from ...engine.methods import Method
from ...engine.settings import revision
from ...engine.space import out_of_view
from ...engine.system import Setup

__all__ = ["CloudMethod", "CloudsRevision", "may_see"]


class CloudsRevision(NamedTuple):
    """Differs whenever clouds do. component: its id; layers: revisions of its further ones; wind: that of the wind."""

    component: int
    revision: int
    layers: tuple[int, ...]
    wind: int

    @classmethod
    def of(cls, component: Clouds, wind: Wind | None) -> CloudsRevision:
        """Of clouds as they are now."""
        layers = tuple(revision(layer) for layer in component.layers)
        return cls(id(component), revision(component), layers, -1 if wind is None else revision(wind))


class CloudMethod(Method):
    """One of Clouds.method."""

    reads: ClassVar[tuple[str, ...]] = ()
    """Resources of the graph that its contracts sample."""
    moving: bool | None = None
    """See System.moving."""

    def __init__(self, gpu: GpuScope, setup: Setup) -> None:
        super().__init__(gpu)
        self.world = setup.world

    @abstractmethod
    def refresh(self, frame: Frame) -> None:
        """Take over what has changed of a component that can be; asked before each `update` while it can."""

    @abstractmethod
    def bind_contract(self, io: PassIO) -> Callable[[], None]:
        """See engine.frame.contracts.ContractSource."""

    @abstractmethod
    def seen_in(self, view: View) -> bool:
        """Whether that view may show any cloud: else none of the picture's passes is in its graph."""


def may_see(frame: Frame, highest_m: float) -> bool:
    """Whether the camera may see cloud below this height: the planet is in view, and the camera not under water."""
    radius = frame.world.get(frame.planet, Planet).radius_m
    sea = frame.world.try_get(frame.planet, Ocean)
    under = sea is not None and frame.camera.altitude_m(radius) < sea.sea_level_m
    return not under and not out_of_view(frame.camera, -frame.camera.position_m, radius + highest_m)
