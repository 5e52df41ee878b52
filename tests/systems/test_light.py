"""The sun's place: the almanac's formulas against published values, turning planets, elevation and azimuth."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from planetfall.systems.light.ephemeris import (
    EARTH_TILT_DEG,
    J2000,
    SIDEREAL_DAY_S,
    TROPICAL_YEAR_S,
    circular_sky,
    earth_sky,
    earth_sun,
    julian_date,
    sidereal_angle_rad,
)
from planetfall.systems.light.sun import resolve_sky, resolve_sun, solar_disc_radiance_scale


@dataclass
class FakeSun:
    direction: tuple[float, float, float] | None = None
    elevation_deg: float | None = None
    azimuth_deg: float = 180.0
    latitude_deg: float = 0.0
    longitude_deg: float = 0.0
    epoch_s: float | None = None
    irradiance: tuple[float, float, float] = (1.474, 1.8504, 1.91198)
    angular_radius_rad: float = 0.004675
    calendar: str = "planet"


@dataclass
class FakePlanet:
    rotation_period_s: float = SIDEREAL_DAY_S
    axial_tilt_deg: float = EARTH_TILT_DEG
    orbital_period_s: float = TROPICAL_YEAR_S


def angle_deg(a, b):
    return float(np.degrees(2.0 * np.arcsin(0.5 * np.linalg.norm(np.asarray(a) - np.asarray(b)))))


def test_julian_date():
    assert julian_date("2000-01-01T12:00:00Z") == J2000
    assert julian_date("1987-04-10") == 2446895.5  # Meeus, example 12.a
    assert julian_date("2000-01-01T13:00:00+01:00") == J2000
    with pytest.raises(ValueError, match=r"not a date.*ISO 8601"):
        julian_date("midsummer")


def test_sun_of_meeus_example_25a():
    # Astronomical Algorithms, 2nd ed., example 25.a: 1992 October 13.0 TD, apparent place.
    ascension, declination, distance = earth_sun(2448908.5)
    assert np.degrees(ascension) == pytest.approx(198.38083, abs=0.02)
    assert np.degrees(declination) == pytest.approx(-7.78507, abs=0.02)
    assert distance == pytest.approx(0.99766, abs=2e-4)


def test_sidereal_time_of_meeus_examples_12():
    assert np.degrees(sidereal_angle_rad(2446895.5)) == pytest.approx(197.693195, abs=1e-5)
    assert np.degrees(sidereal_angle_rad(2446896.30625)) == pytest.approx(128.7378734, abs=1e-5)


@pytest.mark.parametrize(
    ("when", "latitude_deg"),
    [  # instants of the seasons (published to the minute; declination at a solstice: the obliquity)
        ("2024-03-20T03:06:00Z", 0.0),
        ("2024-06-20T20:51:00Z", 23.4364),
        ("2024-09-22T12:44:00Z", 0.0),
        ("2024-12-21T09:21:00Z", -23.4364),
        ("1900-06-21T21:40:00Z", 23.4522),
    ],
)
def test_seasons(when, latitude_deg):
    direction = earth_sky(julian_date(when)).sun_direction
    assert np.degrees(np.arcsin(direction[2])) == pytest.approx(latitude_deg, abs=0.02)


@pytest.mark.parametrize(
    ("day", "equation_of_time_min"),
    [  # apparent minus mean solar time at noon UTC, from tables (e.g. Nautical Almanac), to about 5 s
        ("2024-02-11", -14.22),
        ("2024-04-15", 0.0),
        ("2024-05-14", 3.65),
        ("2024-07-26", -6.55),
        ("2024-11-03", 16.45),
    ],
)
def test_subsolar_longitude_at_noon(day, equation_of_time_min):
    x, y, _ = earth_sky(julian_date(day + "T12:00:00Z")).sun_direction
    longitude_deg = np.degrees(np.arctan2(y, x))
    assert longitude_deg == pytest.approx(-equation_of_time_min * 0.25, abs=0.06)


def test_perihelion_makes_a_larger_brighter_sun():
    sun = FakeSun(epoch_s=(julian_date("2024-01-03T00:39:00Z") - J2000) * 86400.0, calendar="earth")
    state = resolve_sun(sun, FakePlanet())
    assert state.irradiance[1] == pytest.approx(1.8504 / 0.98331**2, rel=1e-3)
    assert state.angular_radius_rad == pytest.approx(0.004675 / 0.98331, rel=1e-3)


def test_circular_planet_starts_at_noon_and_equinox():
    state = resolve_sky(FakeSun(epoch_s=0.0), FakePlanet())
    assert np.allclose(state.sun.direction, (1, 0, 0), atol=1e-12)
    assert np.allclose(state.star_axes, np.eye(3), atol=1e-12)


def test_circular_planet_seasons_and_days():
    quarter = circular_sky(0.25 * TROPICAL_YEAR_S, SIDEREAL_DAY_S, 25.19, TROPICAL_YEAR_S)
    assert np.degrees(np.arcsin(quarter.sun_direction[2])) == pytest.approx(25.19, abs=1e-6)
    # One turn against the stars brings the stars back; the sun needs a little longer on a planet that turns forward.
    sun, planet = FakeSun(epoch_s=1e6), FakePlanet(axial_tilt_deg=0.0)
    first, second = resolve_sky(sun, planet, 0.0), resolve_sky(sun, planet, SIDEREAL_DAY_S)
    assert np.allclose(first.star_axes, second.star_axes, atol=1e-7)
    assert angle_deg(first.sun.direction, second.sun.direction) == pytest.approx(360 / 366.2422, abs=1e-3)
    solar_day_s = 1.0 / (1.0 / SIDEREAL_DAY_S - 1.0 / TROPICAL_YEAR_S)
    assert solar_day_s == pytest.approx(86400.0, abs=0.01)
    assert angle_deg(first.sun.direction, resolve_sky(sun, planet, solar_day_s).sun.direction) < 1e-5
    # It turns to the east: the sun goes west.
    later = resolve_sky(FakeSun(epoch_s=0.0), planet, 3600.0).sun.direction
    assert np.degrees(np.arctan2(later[1], later[0])) == pytest.approx(-15.0, abs=0.05)


def test_locked_and_unmoving_planets():
    locked = circular_sky(1.0665e8, TROPICAL_YEAR_S, 0.0, TROPICAL_YEAR_S)
    assert np.allclose(locked.sun_direction, (1, 0, 0), atol=1e-9)
    assert np.allclose(circular_sky(99.0, 0.0, 10.0, np.inf).sun_direction, (1, 0, 0))


def test_stars_and_sun_turn_together():
    sky = earth_sky(julian_date("2024-08-01T05:00:00Z"))
    ascension, declination, _ = earth_sun(julian_date("2024-08-01T05:00:00Z"))
    inertial = np.array(
        [np.cos(declination) * np.cos(ascension), np.cos(declination) * np.sin(ascension), np.sin(declination)]
    )
    assert np.allclose(sky.star_axes @ inertial, sky.sun_direction, atol=1e-15)
    assert np.allclose(sky.star_axes @ sky.star_axes.T, np.eye(3), atol=1e-15)


def test_elevation_and_azimuth():
    place = {"latitude_deg": 48.0, "longitude_deg": 11.0}
    lat, lon = np.radians(48.0), np.radians(11.0)
    up = np.array([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)])
    overhead = resolve_sun(FakeSun(elevation_deg=90.0, **place), None).direction
    assert np.allclose(overhead, up)
    east = resolve_sun(FakeSun(elevation_deg=0.0, azimuth_deg=90.0, **place), None).direction
    assert np.allclose(east, (-np.sin(lon), np.cos(lon), 0.0))
    north = resolve_sun(FakeSun(elevation_deg=0.0, azimuth_deg=0.0, **place), None).direction
    assert north[2] == pytest.approx(np.cos(lat))
    low = resolve_sun(FakeSun(elevation_deg=-4.0, azimuth_deg=250.0, **place), None).direction
    assert np.degrees(np.arcsin(low @ up)) == pytest.approx(-4.0)
    # At a pole the azimuth is the longitude looked along.
    for latitude_deg in (90.0, -90.0):
        pole = FakeSun(elevation_deg=0.0, azimuth_deg=30.0, latitude_deg=latitude_deg, longitude_deg=77.0)
        assert np.allclose(resolve_sun(pole, None).direction, (np.cos(np.pi / 6), 0.5, 0.0))


def test_direction_mode_and_errors():
    assert np.allclose(resolve_sun(FakeSun(direction=(0, 0, 1e-300)), None).direction, (0, 0, 1))
    assert np.allclose(resolve_sun(FakeSun(), None).direction, (1, 0, 0))
    fixed = FakeSun(direction=(1.0, 2.0, 3.0))
    assert np.array_equal(
        resolve_sun(fixed, FakePlanet(), 0.0).direction, resolve_sun(fixed, FakePlanet(), 9e9).direction
    )
    with pytest.raises(ValueError, match=r"sun.direction.*zero"):
        resolve_sun(replace(fixed, direction=(0.0, 0.0, 0.0)), None)
    with pytest.raises(ValueError, match=r"three finite numbers"):
        resolve_sun(replace(fixed, direction=(float("nan"), 0.0, 0.0)), None)
    with pytest.raises(ValueError, match=r"epoch_s needs a planet"):
        resolve_sun(FakeSun(epoch_s=0.0), None)


def test_disc_radiance_gives_irradiance_back():
    radius = 0.004675
    theta = np.linspace(0.0, radius, 20001)
    integral = np.trapezoid(2 * np.pi * np.cos(theta) * np.sin(theta), theta) * solar_disc_radiance_scale(radius)
    assert integral == pytest.approx(1.0, rel=1e-7)


def test_light_system_publishes_the_axes_of_its_sun():
    from planetfall.components import Planet, Sun
    from planetfall.engine.frame import Frame
    from planetfall.engine.world import World
    from planetfall.systems.light import LightSystem

    world = World("light")
    planet = world.create(Planet(), Sun(epoch_s=0.0))
    sun, body = world.get(planet, Sun), world.get(planet, Planet)
    frame = Frame(world, planet, (8, 8), None, resolve_sun(sun, body, 7200.0), time_s=7200.0)  # type: ignore[arg-type]
    system = LightSystem()
    system.update(frame)
    np.testing.assert_array_equal(frame.star_axes, resolve_sky(sun, body, 7200.0).star_axes)
    # A view's own sun.
    frame.sun, frame.star_axes = resolve_sun(FakeSun(direction=(0.0, 0.0, 1.0)), body), None
    system.update(frame)
    np.testing.assert_array_equal(frame.star_axes, np.eye(3))
    world.close()
