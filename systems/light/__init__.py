"""Light: where the sun and the stars stand. No passes yet; shadows and ambient light will live here."""

from __future__ import annotations

from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...components import Planet, Sun
from ...engine.frame import Frame, SunState
from ...engine.settings import revision
from ...engine.system import System
from .ephemeris import circular_sky, earth_sky, julian_date
from .sun import SkyClock, resolve_sky, resolve_sun

__all__ = ["LightSystem", "SkyClock", "circular_sky", "earth_sky", "julian_date", "resolve_sky", "resolve_sun"]


class _SkyKey(NamedTuple):
    """What the axes of the stars follow from. sun, planet: revisions; time_s: 0 where the sun stands; shining: the
    frame's."""

    sun: int
    planet: int | None
    time_s: float
    shining: SunState


class _Clock:
    """Of one view: the axes that stars had in its last frame, and what they were worked out for."""

    def __init__(self) -> None:
        self.key: _SkyKey | None = None
        self.star_axes: NDArray[np.float64] = np.eye(3)


class LightSystem(System):
    """Says how the stars stand in a frame (Frame.star_axes). The sun itself comes with the frame (Frame.sun)."""

    name: ClassVar[str] = "light"
    essential: ClassVar[bool] = True
    needs: ClassVar[tuple[type, ...]] = (Sun,)

    def update(self, frame: Frame) -> None:
        if frame.star_axes is not None:
            return
        planet = frame.world.try_get(frame.planet, Planet)
        sun = frame.world.query(Sun)[0][1][0]
        moment = frame.time_s if sun.mode == "epoch" else 0.0
        key = _SkyKey(revision(sun), None if planet is None else revision(planet), moment, frame.sun)
        own = frame.view.state(self, _Clock)
        if key != own.key:
            clock = resolve_sky(sun, planet, frame.time_s)
            # A view may bring a sun of its own: then the scene's clock says nothing about its sky.
            same = float(np.abs(clock.sun.direction - frame.sun.direction).max()) < 1e-9
            own.key, own.star_axes = key, clock.star_axes if same else np.eye(3)
        frame.star_axes = own.star_axes
