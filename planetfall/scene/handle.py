"""An entity of a scene as users hold it: its components by type."""

from __future__ import annotations

from typing import Any, Generic, Protocol, TypeVar

from ..components import Sun
from ..engine.world import MissingError, World
from .kinds import SCENE_KINDS, Place, refuse_elsewhere

__all__ = ["Handle", "Parts"]

C = TypeVar("C")


class Holder(Protocol):
    """What a handle needs of the scene that its entity is in."""

    name: str
    world: World


S = TypeVar("S", bound=Holder)


class Parts(Protocol):
    """Whatever has components, at most one of each type: what is worked out from them needs no scene."""

    def get(self, kind: type[C]) -> C | None:
        """The component of this type, or None."""


class Handle(Generic[S]):
    """An entity of a scene: its components by type. `handle[Ocean].sea_level_m = 10.0`, `Ocean in handle`."""

    _place: Place = "scene"

    def __init__(self, scene: S, entity: int, name: str) -> None:
        self.scene = scene
        self.entity = entity
        self.name = name

    def __getitem__(self, kind: type[C]) -> C:
        found = self.get(kind)
        if found is None:
            raise MissingError(self._missing(kind))
        return found

    def get(self, kind: type[C]) -> C | None:
        """The component of this type, or None."""
        return self.scene.world.try_get(self.entity, kind)

    def has(self, kind: type) -> bool:
        """Whether it has a component of this type."""
        return self.scene.world.has(self.entity, kind)

    __contains__ = has

    def add(self, component: C) -> C:
        """Give it this component, in place of one of the same type; returns the component."""
        refuse_elsewhere(component, self._place)
        self.scene.world.add(self.entity, component)
        return component

    def remove(self, kind: type[C]) -> C:
        """Take the component off and return it; what it drew costs nothing from the next frame on."""
        if not self.has(kind):
            raise MissingError(self._missing(kind))
        return self.scene.world.remove(self.entity, kind)

    def components(self) -> tuple[Any, ...]:
        """All its components."""
        return self.scene.world.components(self.entity)

    def _missing(self, kind: type) -> str:
        has = ", ".join(type(c).__name__ for c in self.components()) or "nothing"
        if kind in SCENE_KINDS.values() and self._place == "planet":
            place = "scene.sun" if kind is Sun else f"scene.environment[pf.{kind.__name__}]"
            return f"planet {self.name!r} has no {kind.__name__}; it belongs to the scene: {place}"
        return f"{self._what()} has no {kind.__name__}, only {has}; add one with add(pf.{kind.__name__}())"

    def _what(self) -> str:
        return f"the environment of scene {self.name!r}"

    def __repr__(self) -> str:
        has = ", ".join(type(c).__name__ for c in self.components())
        return f"<{type(self).__name__} {self.name!r}: {has}>"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Handle) and (other.scene is self.scene) and other.entity == self.entity

    def __hash__(self) -> int:
        return hash((id(self.scene), self.entity))
