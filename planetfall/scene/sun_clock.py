"""Time of day and of year over a scene's planets: read from where the sun stands, and set by moving its epoch.

`over` is the name of the planet in whose axes a place is; "" is the scene's own. Companions have days of their own (a
moon that shows its planet one side: a month); the year is always that of the scene's planet.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..errors import SceneError
from ..systems.light.sun import resolve_sun
from .companions import bodies

if TYPE_CHECKING:
    from .scene import Scene

__all__ = ["follow_time", "hour_at", "season", "set_hour", "set_season", "solar_day_s"]

_EARTH_YEAR_S = 365.2422 * 86400.0
_EQUINOX_S = 79.0 * 86400.0 - 43200.0 + 0.3 * 86400.0
"""From 2000-01-01 12:00 UTC, where Earth's calendar starts, to the northern spring equinox of 20 March, 07:35 UTC."""

_SLOPE_S, _STEPS = 60.0, 4
"""Half the span, in seconds, of the slope of a companion's hours: short beside the day of a fast moon (7.6 h). Hours
over a tilted orbit are uneven, so it takes steps."""
_STILL_PER_S = 24.0 / 1e11
"""Hours a second: a day of 3000 years is none."""


def solar_day_s(scene: Scene) -> float:
    """Noon to noon, in seconds: the planet turns a little further than once against the stars."""
    if scene.sun.calendar == "earth":
        return 86400.0
    planet = scene.planet.planet
    turns_per_s = 1.0 / planet.rotation_period_s - 1.0 / planet.orbital_period_s
    # A planet that always shows the sun the same side has no day: its own turn is all there is.
    return abs(1.0 / turns_per_s) if abs(turns_per_s) > 1e-12 else planet.rotation_period_s


def hour_at(scene: Scene, position_m: NDArray[np.float64], time_s: float, over: str = "") -> float:
    """Hour of the local solar day at a place, 0 to 24: 12 where the sun is highest."""
    sun = resolve_sun(scene.sun, scene.planet.planet, time_s).direction
    if over not in ("", scene.planet.name):
        name = scene.companions[over].name  # UnknownNameError for none of them
        sun = next(body for body in bodies(scene, time_s) if body.name == name).axes.T @ sun
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


def set_hour(scene: Scene, position_m: NDArray[np.float64], time_s: float, hour: float, over: str = "") -> None:
    """Make it `hour` (any number; whole days are left away) at a place, on the day that it is.

    SceneError for an hour that isn't finite, and over a companion that always shows the sun the same side.
    """
    if not math.isfinite(hour):
        raise SceneError(f"time of day: expected a finite hour, found {hour!r}")
    follow_time(scene, time_s)
    if over not in ("", scene.planet.name):
        _set_hour_over(scene, position_m, time_s, hour, over)
        return
    away = (hour - hour_at(scene, position_m, time_s) + 12.0) % 24.0 - 12.0
    _shift(scene, away / 24.0 * solar_day_s(scene))


def _set_hour_over(scene: Scene, position_m: NDArray[np.float64], time_s: float, hour: float, over: str) -> None:
    """The same over a companion, whose day follows from its orbit and turning: by the slope of its hours."""

    def away(wanted: float, later_s: float = 0.0) -> float:
        return (wanted - hour_at(scene, position_m, time_s + later_s, over) + 12.0) % 24.0 - 12.0

    for _ in range(_STEPS):
        # Time and epoch are one sum to everything that moves with the sun.
        per_s = away(hour_at(scene, position_m, time_s - _SLOPE_S, over), _SLOPE_S) / (-2.0 * _SLOPE_S)
        if abs(per_s) < _STILL_PER_S:
            raise SceneError(f"time of day: over {over!r} the sun always stands at the same place: it has no hours")
        _shift(scene, away(hour) / per_s)


def set_season(scene: Scene, position_m: NDArray[np.float64], time_s: float, share: float, over: str = "") -> None:
    """Make it that share of the year after the northern spring equinox, at the hour that it is at a place."""
    if not math.isfinite(share):
        raise SceneError(f"time of year: expected a finite share of the year, found {share!r}")
    follow_time(scene, time_s)
    hour = hour_at(scene, position_m, time_s, over)
    year_s = _EARTH_YEAR_S if scene.sun.calendar == "earth" else scene.planet.planet.orbital_period_s
    _shift(scene, ((share - season(scene, time_s) + 0.5) % 1.0 - 0.5) * year_s)
    set_hour(scene, position_m, time_s, hour, over)


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
