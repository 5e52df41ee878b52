"""Light: where the sun and the stars stand. No passes yet; shadows and ambient light will live here.

Publishes the world resource "star_axes": (3, 3) float64, planet = star_axes @ inertial; the sky turns its stars by it.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from ...components import Planet, Sun
from ...engine.frame import Frame
from ...engine.settings import revision
from ...engine.system import System
from .ephemeris import circular_sky, earth_sky, julian_date
from .sun import SkyClock, resolve_sky, resolve_sun

__all__ = ["LightSystem", "SkyClock", "circular_sky", "earth_sky", "julian_date", "resolve_sky", "resolve_sun"]

STAR_AXES = "star_axes"
"""World resource: see above."""


class LightSystem(System):
    """Keeps the star axes of the frame's moment in the world. The sun itself comes with the frame (Frame.sun)."""

    name: ClassVar[str] = "light"
    essential: ClassVar[bool] = True
    needs: ClassVar[tuple[type, ...]] = (Sun,)

    def __init__(self) -> None:
        self._key: tuple[object, ...] = ()

    def update(self, frame: Frame) -> None:
        if frame.star_axes is not None:
            self._key = ()
            frame.world.set_resource(STAR_AXES, frame.star_axes)
            return
        planet = frame.world.try_get(frame.planet, Planet)
        sun = frame.world.query(Sun)[0][1][0]
        moment = frame.time_s if sun.mode == "epoch" else 0.0
        key = (revision(sun), None if planet is None else revision(planet), moment, frame.sun)
        if key == self._key and frame.world.try_resource(STAR_AXES) is not None:
            return
        self._key = key
        clock = resolve_sky(sun, planet, frame.time_s)
        # A view may bring a sun of its own: then the scene's clock says nothing about its sky.
        same = float(np.abs(clock.sun.direction - frame.sun.direction).max()) < 1e-9
        frame.world.set_resource(STAR_AXES, clock.star_axes if same else np.eye(3))
