"""The library's own systems, imported when a world first has something for them to do."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from dataclasses import dataclass

from ..components import Atmosphere, Clouds, Cover, DebugView, Ocean, Planet, Shape, Stars, Sun, Terrain, Transform
from ..engine.system import System
from ..engine.world import World

__all__ = ["SYSTEMS", "Entry", "SystemList", "is_own"]


@dataclass(frozen=True)
class Entry:
    """A system by its place. name and needs are its class's own, known before the class is imported. resource: of the
    world, which has to be there as well."""

    name: str
    module: str
    kind: str
    needs: tuple[type, ...] = ()
    resource: str = ""

    def wanted(self, world: World) -> bool:
        """As System.active."""
        there = not self.resource or world.try_resource(self.resource) is not None
        return there and (not self.needs or bool(world.query(*self.needs)))

    def load(self) -> type[System]:
        """The class."""
        return getattr(importlib.import_module(self.module, "planetfall"), self.kind)


SYSTEMS: tuple[Entry, ...] = (
    Entry("proxy", ".systems.proxy", "ProxySystem", (Planet,)),
    Entry("light", ".systems.light", "LightSystem", (Sun,)),
    Entry("gbuffer", ".systems.gbuffer", "GBufferSystem"),
    Entry("atmosphere", ".systems.atmosphere.system", "AtmosphereSystem", (Planet, Atmosphere)),
    Entry("terrain", ".systems.terrain.system", "TerrainSystem", (Planet, Terrain)),
    Entry("shadows", ".systems.shadows.system", "ShadowSystem", (Planet, Terrain)),
    Entry("ocean", ".systems.ocean", "OceanSystem", (Planet, Ocean)),
    Entry("props", ".systems.props", "PropsSystem", (Transform, Shape)),
    Entry("cover", ".systems.cover", "CoverSystem", (Planet, Terrain, Cover)),
    Entry("sky", ".systems.sky", "SkySystem"),
    Entry("stars", ".systems.sky", "StarsSystem", (Stars,)),
    Entry("clouds", ".systems.clouds.system", "CloudSystem", (Planet, Clouds)),
    Entry("composite", ".systems.composite", "CompositeSystem"),
    Entry("debug", ".systems.debug", "DebugSystem", (DebugView,)),
    Entry("companions", ".systems.companions", "CompanionsSystem", resource="companions.source"),
)
"""In the order of their updates; companions begin last, when the frame's jitter is known. The order of the passes comes
from the graph."""


_OWN = frozenset(entry.kind for entry in SYSTEMS)


def is_own(system: System) -> bool:
    """Whether a system is of the library, not of a game."""
    kind = type(system)
    return kind.__name__ in _OWN and kind.__module__.startswith("planetfall.systems.")


class SystemList:
    """One renderer's systems: the library's as its world comes to need them, a game's own from the start."""

    def __init__(self, further: Sequence[type[System]]) -> None:
        self._places: list[Entry | System] = [*SYSTEMS, *(kind() for kind in further)]

    def needed(self, world: World) -> tuple[System, ...]:
        """All that the world needs now or has needed before, running or not, in the order of their updates."""
        for number, place in enumerate(self._places):
            if isinstance(place, Entry) and place.wanted(world):
                self._places[number] = place.load()()
        return tuple(place for place in self._places if isinstance(place, System))
