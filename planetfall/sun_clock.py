"""Time of day and of year over a scene's planet: read from where the sun stands, and set by moving its epoch."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .errors import SceneError
from .systems.light.sun import resolve_sun

if TYPE_CHECKING:
    from .scene import Scene

__all__ = ["follow_time", "hour_at", "season", "set_hour", "set_season", "solar_day_s"]

_EARTH_YEAR_S = 365.2422 * 86400.0
_EQUINOX_S = 79.0 * 86400.0 - 43200.0 + 0.3 * 86400.0
"""From 2000-01-01 12:00 UTC, where Earth's calendar starts, to the northern spring equinox of 20 March, 07:35 UTC."""


def solar_day_s(scene: Scene) -> float:
    """Noon to noon, in seconds: the planet turns a little further than once against the stars."""
    if scene.sun.calendar == "earth":
        return 86400.0
    planet = scene.planet.planet
    turns_per_s = 1.0 / planet.rotation_period_s - 1.0 / planet.orbital_period_s
    # A planet that always shows the sun the same side has no day: its own turn is all there is.
    return abs(1.0 / turns_per_s) if abs(turns_per_s) > 1e-12 else planet.rotation_period_s


def hour_at(scene: Scene, position_m: NDArray[np.float64], time_s: float) -> float:
    """Hour of the local solar day at a place, 0 to 24: 12 where the sun is highest."""
    sun = resolve_sun(scene.sun, scene.planet.planet, time_s).direction
    return (12.0 + _angle(_longitude(position_m) - _longitude(sun)) * 12.0 / math.pi) % 24.0


def season(scene: Scene, time_s: float) -> float:
    """Share of the year since the northern spring equinox, 0 to 1.

    For a sun that stands still: that of the two seasons with its declination that comes first.
    """
    sun, planet = scene.sun, scene.planet.planet
    if sun.epoch_s is not None:
        now_s = sun.epoch_s + time_s
        if sun.calendar == "earth":
            return ((now_s - _EQUINOX_S) / _EARTH_YEAR_S) % 1.0
        return (now_s / planet.orbital_period_s) % 1.0
    tilt = math.sin(math.radians(23.44 if sun.calendar == "earth" else planet.axial_tilt_deg))
    height = float(resolve_sun(sun, planet, time_s).direction[2])
    if abs(tilt) < 1e-6:
        return 0.0
    return (math.asin(min(max(height / tilt, -1.0), 1.0)) / (2.0 * math.pi)) % 1.0


def follow_time(scene: Scene, time_s: float) -> None:
    """Make the sun follow the time from where it stands now: the same hour everywhere, and the nearest season.

    Does nothing to a sun that does already.
    """
    if scene.sun.epoch_s is None:
        sun = resolve_sun(scene.sun, scene.planet.planet, time_s).direction
        _put(scene, time_s, season(scene, time_s), _longitude(sun))


def set_hour(scene: Scene, position_m: NDArray[np.float64], time_s: float, hour: float) -> None:
    """Make it `hour` (any number; whole days are left away) at a place, on the day that it is."""
    if not math.isfinite(hour):
        raise SceneError(f"time of day: expected a finite hour, found {hour!r}")
    follow_time(scene, time_s)
    away = (hour - hour_at(scene, position_m, time_s) + 12.0) % 24.0 - 12.0
    _shift(scene, away / 24.0 * solar_day_s(scene))


def set_season(scene: Scene, position_m: NDArray[np.float64], time_s: float, share: float) -> None:
    """Make it that share of the year after the northern spring equinox, at the hour that it is at a place."""
    if not math.isfinite(share):
        raise SceneError(f"time of year: expected a finite share of the year, found {share!r}")
    follow_time(scene, time_s)
    hour = hour_at(scene, position_m, time_s)
    year_s = _EARTH_YEAR_S if scene.sun.calendar == "earth" else scene.planet.planet.orbital_period_s
    _shift(scene, ((share - season(scene, time_s) + 0.5) % 1.0 - 0.5) * year_s)
    set_hour(scene, position_m, time_s, hour)


def _shift(scene: Scene, seconds: float) -> None:
    epoch = (scene.sun.epoch_s or 0.0) + seconds
    limit = 1e12  # the knob's: 30 000 years
    scene.sun.epoch_s = min(max(epoch, -limit), limit)


def _put(scene: Scene, time_s: float, share: float, longitude: float) -> None:
    """An epoch in that season at which the sun stands over a longitude (rad)."""
    earth = scene.sun.calendar == "earth"
    planet = scene.planet.planet
    scene.sun.epoch_s = share * _EARTH_YEAR_S + _EQUINOX_S if earth else share * planet.orbital_period_s
    _shift(scene, -time_s)
    day = solar_day_s(scene)
    for _ in range(3):  # hours are not quite even over the year
        now = _longitude(resolve_sun(scene.sun, planet, time_s).direction)
        _shift(scene, _angle(now - longitude) / (2.0 * math.pi) * day)


def _longitude(vector: NDArray[np.float64]) -> float:
    return math.atan2(float(vector[1]), float(vector[0]))


def _angle(radians: float) -> float:
    """The same angle in -pi to pi."""
    return (radians + math.pi) % (2.0 * math.pi) - math.pi
