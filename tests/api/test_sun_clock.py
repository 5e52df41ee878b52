"""Time of day and of year: against the sun's height by the textbook, on planets and on Earth's calendar."""

from __future__ import annotations

import math

import numpy as np
import pytest

import planetfall as pf
from planetfall.scene import sun_clock
from planetfall.systems.light.sun import resolve_sun

TILT = math.radians(23.4393)


def elevation_deg(scene: pf.Scene, up: np.ndarray, time_s: float) -> float:
    return math.degrees(math.asin(float(resolve_sun(scene.sun, scene.planet.planet, time_s).direction @ up)))


def textbook_deg(latitude_deg: float, hour: float, share: float) -> float:
    """sin h = sin lat sin dec + cos lat cos dec cos H (Meeus, Astronomical Algorithms, 13.6), on a circular orbit."""
    latitude, declination = math.radians(latitude_deg), math.asin(math.sin(TILT) * math.sin(2.0 * math.pi * share))
    angle = math.radians((hour - 12.0) * 15.0)
    return math.degrees(
        math.asin(
            math.sin(latitude) * math.sin(declination) + math.cos(latitude) * math.cos(declination) * math.cos(angle)
        )
    )


@pytest.mark.parametrize("calendar", ["planet", "earth"])
@pytest.mark.parametrize("time_s", [0.0, 12345.0])
def test_hours_and_seasons_put_the_sun_where_it_belongs(calendar: str, time_s: float) -> None:
    with pf.load_scene("earth") as scene:
        scene.sun.calendar = calendar
        for latitude, longitude, hour, share in ((50, 10, 12, 0.25), (-30, 170, 8.5, 0.75), (65, -120, 23.0, 0.4)):
            up = pf.direction(latitude, longitude)
            place = up * 6.4e6
            sun_clock.set_season(scene, place, time_s, share)
            sun_clock.set_hour(scene, place, time_s, hour)
            assert sun_clock.hour_at(scene, place, time_s) == pytest.approx(hour, abs=0.01)
            assert sun_clock.season(scene, time_s) == pytest.approx(share, abs=0.003)
            # Earth's orbit is no circle: its seasons differ from those of a circular one by up to 2 degrees.
            found = elevation_deg(scene, up, time_s)
            assert found == pytest.approx(textbook_deg(latitude, hour, share), abs=0.5 if calendar == "planet" else 2.5)


def test_a_sun_that_begins_to_follow_the_time_does_not_jump() -> None:
    with pf.load_scene("earth") as scene:
        scene.sun = pf.Sun(elevation_deg=50.0, azimuth_deg=200.0, latitude_deg=30.0, longitude_deg=40.0)
        before = resolve_sun(scene.sun, None).direction
        sun_clock.follow_time(scene, 500.0)
        after = resolve_sun(scene.sun, scene.planet.planet, 500.0).direction
        assert math.degrees(math.acos(min(float(before @ after), 1.0))) < 0.5
        epoch = scene.sun.epoch_s
        sun_clock.follow_time(scene, 500.0)
        assert scene.sun.epoch_s == epoch
        place = pf.direction(30.0, 40.0) * 6.4e6
        hour = sun_clock.hour_at(scene, place, 500.0)
        assert sun_clock.hour_at(scene, place, 500.0 + 3600.0) == pytest.approx(hour + 1.0, abs=0.01)


def test_the_day_of_other_planets() -> None:
    with pf.load_scene("earth") as scene:
        assert sun_clock.solar_day_s(scene) == pytest.approx(86400.0, abs=1.0)
        scene.sun.calendar, planet = "planet", scene.planet.planet
        planet.rotation_period_s = planet.orbital_period_s  # always the same side
        assert sun_clock.solar_day_s(scene) == planet.rotation_period_s
        with pytest.raises(pf.SettingError, match="finite hour"):
            sun_clock.set_hour(scene, pf.direction(0, 0), 0.0, math.nan)


ORBITS = [
    pytest.param(pf.Orbit(distance_m=3.844e8, period_s=2.36e6, inclination_deg=20.0, phase_deg=50.0), id="month"),
    pytest.param(pf.Orbit(distance_m=2.0e7, period_s=2.75e4, inclination_deg=1.0), id="phobos"),
    pytest.param(pf.Orbit(distance_m=3.844e8, period_s=2.36e6, inclination_deg=160.0), id="backwards"),
    pytest.param(pf.Orbit(distance_m=3.844e8, period_s=2.36e6, locked=False), id="own turn"),
]


@pytest.mark.parametrize("calendar", ["planet", "earth"])
@pytest.mark.parametrize("orbit", ORBITS)
def test_hours_over_a_companion(orbit: pf.Orbit, calendar: str) -> None:
    """At its noon the sun is in the plane of the place's meridian, at 18 h it goes down in the west."""
    with pf.Scene("earth", {"planet": pf.Planet()}) as scene:
        scene.sun.calendar = calendar
        scene.companions.add(pf.Scene("moon", {"planet": pf.Planet(radius_m=1.7e6, rotation_period_s=3e5)}), orbit)
        place, time_s = pf.direction(10.0, 130.0) * 1.7e6, 5e4
        for hour in (12.0, 18.0, 3.5):
            sun_clock.set_hour(scene, place, time_s, hour, "moon")
            assert sun_clock.hour_at(scene, place, time_s, "moon") == pytest.approx(hour, abs=0.01)
            sun = pf.sun_direction(scene, time_s, pf.Camera.at(10.0, 130.0, 500.0, planet="moon"))
            # Hour angle by definition: how far, about the pole, the sun is west of the meridian, 15 degrees an hour.
            west = math.radians(130.0) - math.atan2(sun[1], sun[0])
            assert math.cos(west - math.radians(15.0 * (hour - 12.0))) > 0.99999
        sun_clock.set_season(scene, place, time_s, 0.25, "moon")
        assert sun_clock.season(scene, time_s) == pytest.approx(0.25, abs=0.1)  # to the nearest of its long days
        assert sun_clock.hour_at(scene, place, time_s, "moon") == pytest.approx(3.5, abs=0.01)


def test_a_companion_without_hours_says_so() -> None:
    with pf.Scene("earth", {"planet": pf.Planet(rotation_period_s=86400.0, orbital_period_s=86400.0)}) as scene:
        scene.sun.calendar = "planet"
        still = pf.Orbit(
            position_m=(1e9, 0.0, 0.0)
        )  # with the axes of a planet that always shows the sun the same side
        scene.companions.add(pf.Scene("moon", {"planet": pf.Planet(radius_m=1e6)}), still)
        with pytest.raises(pf.SceneError, match="over 'moon' the sun always stands at the same place"):
            sun_clock.set_hour(scene, np.array([1e6, 0.0, 0.0]), 0.0, 6.0, "moon")
