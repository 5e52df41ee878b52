"""Which components a scene file may have, and under which table names: the one list of it."""

from __future__ import annotations

from . import ASSETS
from .components import (
    Atmosphere,
    CloudLayer,
    Clouds,
    Composite,
    DebugView,
    Exposure,
    Ocean,
    Planet,
    Shape,
    Stars,
    Sun,
    Terrain,
    Transform,
)
from .engine.settings import install

__all__ = ["KINDS", "PLANET_KINDS", "PRESETS", "PROP_KINDS", "SCENE_KINDS"]

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

for _kind in (*KINDS.values(), *PROP_KINDS.values(), DebugView, CloudLayer):
    install(_kind)
