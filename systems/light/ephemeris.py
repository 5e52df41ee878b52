"""Where the sun and the stars stand over a rotating planet: pure float64 functions of time, no components, no GL.

Two models share one result. Earth uses the low-precision solar coordinates of the Astronomical Almanac (section C,
"Low precision formulas for the Sun's coordinates"; the same series is the US Naval Observatory's "Approximate Solar
Coordinates"): good to about 0.01-0.02 degrees from 1800 to 2200, and Greenwich mean sidereal time (Meeus, Astronomical
Algorithms, 2nd ed., eq. 12.4). Any other planet is a circular orbit: an axis tilted against the orbit, a rotation
period and a year, counted from a moment when the sun stands at the vernal equinox over longitude 0.

Frames. Inertial: z along the planet's north pole, x towards its vernal equinox (for Earth: mean equator and equinox of
date). Planet: fixed to the ground, z the same pole, x at longitude 0. They differ by the rotation angle about z.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "EARTH_TILT_DEG",
    "J2000",
    "SIDEREAL_DAY_S",
    "TROPICAL_YEAR_S",
    "SkyState",
    "circular_sky",
    "earth_sky",
    "earth_sun",
    "julian_date",
    "sidereal_angle_rad",
]

J2000 = 2451545.0
"""Julian date of 2000 January 1, 12:00."""
SIDEREAL_DAY_S = 86164.0905
TROPICAL_YEAR_S = 365.24219 * 86400.0
EARTH_TILT_DEG = 23.4393


@dataclass(frozen=True, eq=False)
class SkyState:
    """sun_direction: (3,) unit, planet axes. star_axes: (3, 3), planet = star_axes @ inertial.

    sun_distance: in units of the mean distance (astronomical units for Earth).
    """

    sun_direction: NDArray[np.float64]
    star_axes: NDArray[np.float64]
    sun_distance: float


def julian_date(when: str | datetime) -> float:
    """Julian date (UTC) of an ISO 8601 text such as "2024-06-20T20:51:00Z" or of a datetime; no time zone means UTC.

    Raises ValueError naming the text and the expected form.
    """
    if isinstance(when, str):
        try:
            moment = datetime.fromisoformat(when.strip())
        except ValueError as error:
            raise ValueError(
                f"epoch {when!r} is not a date: expected ISO 8601 in UTC, such as '2024-06-20T12:00:00Z'"
            ) from error
    else:
        moment = when
    moment = moment.replace(tzinfo=UTC) if moment.tzinfo is None else moment.astimezone(UTC)
    since = moment - datetime(2000, 1, 1, 12, tzinfo=UTC)
    return J2000 + since.days + (since.seconds + since.microseconds * 1e-6) / 86400.0


def earth_sun(jd: float) -> tuple[float, float, float]:
    """Right ascension and declination (rad) and distance (au) of the sun for a Julian date."""
    days = jd - J2000
    anomaly = np.radians((357.529 + 0.98560028 * days) % 360.0)
    mean_longitude_deg = (280.459 + 0.98564736 * days) % 360.0
    longitude = np.radians(mean_longitude_deg + 1.915 * np.sin(anomaly) + 0.020 * np.sin(2.0 * anomaly))
    obliquity = np.radians(23.439 - 3.6e-7 * days)
    distance = 1.00014 - 0.01671 * np.cos(anomaly) - 0.00014 * np.cos(2.0 * anomaly)
    ascension = np.arctan2(np.cos(obliquity) * np.sin(longitude), np.cos(longitude))
    declination = np.arcsin(np.sin(obliquity) * np.sin(longitude))
    return float(ascension % (2.0 * np.pi)), float(declination), float(distance)


def sidereal_angle_rad(jd: float) -> float:
    """Greenwich mean sidereal time as an angle in [0, 2 pi), for a Julian date in UT."""
    days = jd - J2000
    century = days / 36525.0
    # Whole turns leave before the multiplication, so that the angle keeps its digits far from the year 2000.
    whole, part = np.divmod(days, 1.0)
    angle_deg = 280.46061837 + 360.0 * part + 0.98564736629 * (whole + part) + century * century * 0.000387933
    return float(np.radians(angle_deg % 360.0))


def _spherical(ascension: float, declination: float) -> NDArray[np.float64]:
    flat = np.cos(declination)
    return np.array([flat * np.cos(ascension), flat * np.sin(ascension), np.sin(declination)])


def _turned(angle_rad: float) -> NDArray[np.float64]:
    """Inertial to planet: the planet has turned by this angle about +z, so the sky turns back."""
    c, s = float(np.cos(angle_rad)), float(np.sin(angle_rad))
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def earth_sky(jd: float) -> SkyState:
    """Sun and stars over Earth at a Julian date (UT and UTC are taken as the same: 0.9 s, 0.004 degrees at most)."""
    ascension, declination, distance = earth_sun(jd)
    axes = _turned(sidereal_angle_rad(jd))
    return SkyState(axes @ _spherical(ascension, declination), axes, distance)


def circular_sky(time_s: float, rotation_period_s: float, axial_tilt_deg: float, year_s: float) -> SkyState:
    """Sun and stars over a planet on a circular orbit.

    time_s: since noon at longitude 0 at the northern spring equinox. rotation_period_s: sidereal; negative turns
    backwards, 0 or infinite never. year_s: likewise.
    """

    def turns(period_s: float) -> float:
        return 0.0 if period_s == 0.0 or not np.isfinite(period_s) else float(np.fmod(time_s / period_s, 1.0))

    longitude = 2.0 * np.pi * turns(year_s)
    tilt = np.radians(axial_tilt_deg)
    sun = np.array([np.cos(longitude), np.cos(tilt) * np.sin(longitude), np.sin(tilt) * np.sin(longitude)])
    axes = _turned(2.0 * np.pi * turns(rotation_period_s))
    return SkyState(axes @ sun, axes, 1.0)
