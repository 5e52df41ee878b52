"""Which components a scene file may have, and under which table names: the one list of it."""

from __future__ import annotations

from .. import ASSETS
from ..components import (
    Atmosphere,
    CloudLayer,
    Clouds,
    Composite,
    DebugView,
    Exposure,
    Ocean,
    Orbit,
    Planet,
    Shape,
    Stars,
    Sun,
    Terrain,
    Transform,
)
from ..engine.settings import install

__all__ = ["KINDS", "PLANET_KINDS", "PRESETS", "PROP_KINDS", "SCENE_KINDS", "add_kind", "remove_kind"]

PRESETS = ASSETS / "presets"

PLANET_KINDS: dict[str, type] = {
    "planet": Planet,
    "terrain": Terrain,
    "ocean": Ocean,
    "atmosphere": Atmosphere,
    "clouds": Clouds,
}
"""Components of a planet, by their TOML table."""
SCENE_KINDS: dict[str, type] = {"sun": Sun, "stars": Stars, "exposure": Exposure, "composite": Composite}
"""Components of the scene itself."""
KINDS: dict[str, type] = {**PLANET_KINDS, **SCENE_KINDS}
PROP_KINDS: dict[str, type] = {"transform": Transform, "shape": Shape}
"""Components of an object of a game's, of which a scene may have any number: tables inside [[props]]."""

for _kind in (*KINDS.values(), *PROP_KINDS.values(), DebugView, CloudLayer, Orbit):
    install(_kind)


def add_kind(table: str, kind: type, place: str) -> None:
    """One more component, of a game's: place is "planet" or "scene". `extend.register` checks and calls this."""
    install(kind)
    KINDS[table] = (PLANET_KINDS if place == "planet" else SCENE_KINDS)[table] = kind


def remove_kind(table: str) -> None:
    """The opposite of add_kind."""
    for kinds in (KINDS, PLANET_KINDS, SCENE_KINDS):
        kinds.pop(table, None)
