"""Light: where the sun and the stars stand. No passes yet; shadows and ambient light will live here.

Publishes the world resource "star_axes": (3, 3) float64, planet = star_axes @ inertial; the sky turns its stars by it.
"""

from __future__ import annotations

from typing import ClassVar

from ...components import Planet, Sun
from ...engine.system import Frame, System
from .ephemeris import circular_sky, earth_sky, julian_date
from .sun import SkyClock, resolve_sky, resolve_sun

__all__ = ["LightSystem", "SkyClock", "circular_sky", "earth_sky", "julian_date", "resolve_sky", "resolve_sun"]

STAR_AXES = "star_axes"


class LightSystem(System):
    """Keeps the star axes of the frame's moment in the world. The sun itself comes with the frame (Frame.sun)."""

    name: ClassVar[str] = "light"
    needs: ClassVar[tuple[type, ...]] = (Sun,)

    def update(self, frame: Frame) -> None:
        suns = frame.world.query(Sun)
        planet = frame.world.try_get(frame.planet, Planet)
        if suns:
            frame.world.set_resource(STAR_AXES, resolve_sky(suns[0][1][0], planet, frame.time_s).star_axes)
