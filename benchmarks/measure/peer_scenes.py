"""Scenes and cameras of suite `peers`: a sky over plain ground as the peer draws it, with clouds, and a whole planet.

Imports little but the public API, because a start is measured with it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from ... import Camera, Composite, Cover, Exposure, Ocean, Scene, Stars, Sun, Terrain
from ..scenes import earth, preset_scene

__all__ = ["SCENES", "TIME_S", "camera", "sun"]

LATITUDE_DEG, LONGITUDE_DEG = 3.2, 143.6
"""Woods among hills and lakes on `earth`, land for 800 km to the east and the sea behind it."""
TIME_S = 6.0e4
"""Scattered cumulus there, and cirrus."""
_VIEWS = {"ground": (100.0, 8.0), "air10km": (1.0e4, -8.0), "space": (2.0e6, -38.0)}
"""Metres above the ground, and pitch in degrees."""
_GREEN = (0.025, 0.069, 0.040)


def camera(name: str) -> Camera:
    """Of one of the peer's views: level with the east, 60 degrees high."""
    altitude_m, pitch_deg = _VIEWS[name]
    return Camera.at(
        LATITUDE_DEG, LONGITUDE_DEG, altitude_m, heading_deg=90.0, pitch_deg=pitch_deg, fov_y_deg=60.0, above="ground"
    )


def sun() -> Sun:
    """The peer's: so much of up, east and north."""
    up, east, north = math.sin(math.radians(25.0)), 0.9 * math.cos(math.radians(25.0)), 0.3
    return Sun(
        elevation_deg=math.degrees(math.atan2(up, math.hypot(east, north))),
        azimuth_deg=math.degrees(math.atan2(east, north)),
        latitude_deg=LATITUDE_DEG,
        longitude_deg=LONGITUDE_DEG,
    )


def _ball(clouds: bool) -> Scene:
    """Air, and Earth's clouds, over a smooth green ball; shown as the peer shows it: a fixed exposure, AgX, and none of
    what it has not (stars, glare, anti-aliasing, dither)."""
    scene = preset_scene("earth", clouds)
    planet, around = scene.planet, scene.environment
    for kind in (Ocean, Cover, Terrain):
        if planet.has(kind):
            planet.remove(kind)
    planet.add(
        Terrain(
            highest_m=1.0, lowest_m=-1.0, layers=1, mountains=0.0, hills=0.0, roughness=0.0, warp=0.0, strata=0.0,
            variation=0.0, grain=0.0, clutter=0.0, plants=0.0, snow_line_m=1e6, snow_line_pole_m=1e6,
            rock_albedo=_GREEN, dry_albedo=_GREEN, sand_albedo=_GREEN,
        )
    )  # fmt: skip
    around.remove(Stars)
    composite, exposure = around[Composite], around[Exposure]
    composite.antialiasing, composite.tone_map, composite.bloom, composite.dither = "none", "agx", 0.0, False
    exposure.mode, exposure.ev100 = "fixed", 13.0
    return scene


SCENES: Mapping[str, Callable[[], Scene]] = {
    "sky": lambda: _ball(False),
    "clouds": lambda: _ball(True),
    "whole": lambda: preset_scene("earth", clouds=True),
    "bare": lambda: earth(erosion=0.0, rivers=0.0, clouds=True),
}
"""Makers, by what is drawn: a whole planet with all it has, or without gullies, rivers and trees."""
