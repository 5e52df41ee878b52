"""From a Sun component to where the sun and the stars are in one moment, in planet axes, float64."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ...engine.frame import SunState
from .ephemeris import J2000, SkyState, circular_sky, earth_sky

__all__ = ["SkyClock", "SunSettings", "TurningPlanet", "resolve_sky", "resolve_sun", "solar_disc_radiance_scale"]


class SunSettings(Protocol):
    """What is read from the Sun component; direction, elevation_deg, epoch_s: the one that isn't None counts."""

    direction: tuple[float, float, float] | None
    elevation_deg: float | None
    azimuth_deg: float
    latitude_deg: float
    longitude_deg: float
    epoch_s: float | None
    irradiance: tuple[float, float, float]
    angular_radius_rad: float


class TurningPlanet(Protocol):
    """What is read from the Planet component."""

    rotation_period_s: float
    axial_tilt_deg: float
    orbital_period_s: float


@dataclass(frozen=True, eq=False)
class SkyClock:
    """sun: as the frame wants it. star_axes: (3, 3) f64, planet = star_axes @ inertial; the identity unless the sun is
    in epoch mode: a sun that stands still has stars that stand still."""

    sun: SunState
    star_axes: NDArray[np.float64]


def _unit(vector: Sequence[float], what: str) -> NDArray[np.float64]:
    v = np.asarray(vector, dtype=np.float64)
    if v.shape != (3,) or not np.all(np.isfinite(v)):
        raise ValueError(f"{what}: expected three finite numbers, found {vector!r}")
    largest = float(np.max(np.abs(v)))
    if largest == 0.0:
        raise ValueError(f"{what}: expected a vector of any length but zero, found {vector!r}")
    v = v / largest  # so that tiny and huge vectors keep their direction
    return v / np.sqrt(v @ v)


def _seen_from(
    elevation_deg: float, azimuth_deg: float, latitude_deg: float, longitude_deg: float
) -> NDArray[np.float64]:
    """Unit direction of a body at this elevation and azimuth (0 north, 90 east) over a place of the planet.

    At a pole the azimuth is the longitude looked along, as for headings of cameras.
    """
    elevation, azimuth, latitude, longitude = np.radians([elevation_deg, azimuth_deg, latitude_deg, longitude_deg])
    up = np.array([np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)])
    east = np.array([-np.sin(longitude), np.cos(longitude), 0.0])
    if abs(latitude_deg) >= 90.0:
        up = np.array([0.0, 0.0, np.copysign(1.0, latitude_deg)])
        north, east = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    else:
        north = np.cross(up, east)
    level = np.cos(azimuth) * north + np.sin(azimuth) * east
    return _unit(np.cos(elevation) * level + np.sin(elevation) * up, "sun")


def _epoch_sky(sun: SunSettings, planet: TurningPlanet, time_s: float) -> SkyState:
    now_s = float(sun.epoch_s or 0.0) + float(time_s)
    if getattr(sun, "calendar", "planet") == "earth":
        return earth_sky(J2000 + now_s / 86400.0)
    return circular_sky(now_s, planet.rotation_period_s, planet.axial_tilt_deg, planet.orbital_period_s)


def resolve_sky(sun: SunSettings, planet: TurningPlanet | None, time_s: float = 0.0) -> SkyClock:
    """Sun and star axes at time_s. Only a sun in epoch mode moves with time.

    epoch_s counts from noon at longitude 0 at the northern spring equinox, on a circular orbit; with
    `calendar="earth"` from 2000-01-01 12:00 UTC with the almanac's sun, whose irradiance and disc then follow the
    distance. Raises ValueError for a direction that isn't one, and for an epoch without a planet.
    """
    irradiance = np.asarray(sun.irradiance, dtype=np.float64)
    radius = float(sun.angular_radius_rad)
    axes = np.eye(3)
    if sun.epoch_s is not None:
        if planet is None:
            raise ValueError("sun: epoch_s needs a planet that turns below it; give direction or elevation_deg instead")
        sky = _epoch_sky(sun, planet, time_s)
        direction, axes = sky.sun_direction, sky.star_axes
        irradiance = irradiance / sky.sun_distance**2
        radius = radius / sky.sun_distance
    elif sun.elevation_deg is not None:
        direction = _seen_from(sun.elevation_deg, sun.azimuth_deg, sun.latitude_deg, sun.longitude_deg)
    else:
        direction = _unit(sun.direction if sun.direction is not None else (1.0, 0.0, 0.0), "sun.direction")
    return SkyClock(SunState(direction, irradiance, radius), axes)


def resolve_sun(sun: SunSettings, planet: TurningPlanet | None, time_s: float = 0.0) -> SunState:
    """Direction, irradiance and disc of the sun at time_s; see `resolve_sky`."""
    return resolve_sky(sun, planet, time_s).sun


def solar_disc_radiance_scale(angular_radius_rad: float) -> float:
    """1 / solid angle (sr) of the disc: mean radiance of the disc per irradiance at normal incidence.

    The projected solid angle pi sin^2 a, so that the irradiance integral over the disc gives back what went in.
    """
    return 1.0 / (np.pi * np.sin(angular_radius_rad) ** 2)
