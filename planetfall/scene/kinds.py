"""Which components a scene file may have, and under which table names: the one list of it."""

from __future__ import annotations

from typing import Any, Literal

from .. import ASSETS
from ..components import (
    Atmosphere,
    CloudLayer,
    Clouds,
    Composite,
    Cover,
    CoverSpecies,
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
    Wind,
)
from ..engine.settings import install
from ..errors import SceneError

__all__ = [
    "KINDS",
    "PLANET_KINDS",
    "PRESETS",
    "PROP_KINDS",
    "SCENE_KINDS",
    "SUFFIX",
    "Place",
    "add_kind",
    "refuse_elsewhere",
    "remove_kind",
]

Place = Literal["planet", "scene", "prop"]
"""What a component is part of: a planet, the scene itself, or an object of a game's."""

SUFFIX = ".planetfall"
"""Of scenes that are shared as one file."""
PRESETS = ASSETS / "presets"

PLANET_KINDS: dict[str, type] = {
    "planet": Planet,
    "terrain": Terrain,
    "ocean": Ocean,
    "atmosphere": Atmosphere,
    "clouds": Clouds,
    "cover": Cover,
    "wind": Wind,
}
"""Components of a planet, by their TOML table."""
SCENE_KINDS: dict[str, type] = {"sun": Sun, "stars": Stars, "exposure": Exposure, "composite": Composite}
"""Components of the scene itself."""
KINDS: dict[str, type] = {**PLANET_KINDS, **SCENE_KINDS}
PROP_KINDS: dict[str, type] = {"transform": Transform, "shape": Shape}
"""Components of an object of a game's, of which a scene may have any number: tables inside [[props]]."""

for _kind in (*KINDS.values(), *PROP_KINDS.values(), DebugView, CloudLayer, CoverSpecies, Orbit):
    install(_kind)


def refuse_elsewhere(component: Any, here: Place) -> None:
    """SceneError, which says where it belongs, for a component (or a type of one) that belongs elsewhere."""
    kind = component if isinstance(component, type) else type(component)
    of_planet, of_scene = kind in PLANET_KINDS.values(), kind in SCENE_KINDS.values()
    if here == "prop" and (of_planet or of_scene):
        place = "scene.planet" if of_planet else "scene.environment"
        raise SceneError(f"{kind.__name__} belongs to no object of a game's; add it with {place}.add(...)")
    if here == "scene" and of_planet:
        raise SceneError(f"{kind.__name__} belongs to a planet; add it with scene.planet.add(...)")
    if here == "planet" and of_scene:
        place = "assign scene.sun" if kind is Sun else "add it with scene.environment.add(...)"
        raise SceneError(f"{kind.__name__} belongs to the scene, not to a planet; {place}")
    if here != "prop" and kind in PROP_KINDS.values():
        raise SceneError(f"{kind.__name__} belongs to an object of its own: scene.add(pf.Transform(), pf.Shape())")


def add_kind(table: str, kind: type, place: str) -> None:
    """One more component, of a game's: place is "planet" or "scene". `extend.register` checks and calls this."""
    install(kind)
    KINDS[table] = (PLANET_KINDS if place == "planet" else SCENE_KINDS)[table] = kind


def remove_kind(table: str) -> None:
    """The opposite of add_kind."""
    for kinds in (KINDS, PLANET_KINDS, SCENE_KINDS):
        kinds.pop(table, None)
