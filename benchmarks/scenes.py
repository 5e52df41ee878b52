"""Scenes of presets as benches and golden pictures take them: without clouds, unless they are what is looked at."""

from __future__ import annotations

import os

from .. import Clouds, Cover, Scene, Terrain, load_scene

__all__ = ["earth", "preset_scene"]


def preset_scene(source: str | os.PathLike[str] = "earth", clouds: bool = False) -> Scene:
    """As load_scene; without `clouds` no planet of it has any.

    Clouds hide ground and sea and cost more than both: figures and pictures of those would say little under them.
    """
    scene = load_scene(source)
    for planet in () if clouds else scene.planets.values():
        if planet.has(Clouds):
            planet.remove(Clouds)
    return scene


def earth(erosion: float, rivers: float, clouds: bool = False) -> Scene:
    """The preset earth with so much of gullies and rivers, and no trees: without all, the ground that printed methods
    know."""
    scene = preset_scene("earth", clouds)
    scene.planet.remove(Cover)
    terrain = scene.planet[Terrain]
    terrain.erosion, terrain.rivers = erosion, rivers
    return scene
