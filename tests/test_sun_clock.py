"""Time of day and of year: against the sun's height by the textbook, on planets and on Earth's calendar."""

from __future__ import annotations

import math

import numpy as np
import pytest

import planetfall as pf
from planetfall import sun_clock
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
