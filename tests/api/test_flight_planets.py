"""Flights from one planet of a scene to another: one way in the scene's axes, whoever's axes the pilot is in."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from app_kit import app_of

import planetfall as pf
from planetfall.app.panels import SettingsWindow
from planetfall.engine.input import KeyEvent
from planetfall.scene.companions import bodies
from planetfall.systems.tweak import FrameHistory

DISTANCE_M = 3.844e8


@pytest.fixture
def flight() -> Any:
    with pf.Scene("earth", {"planet": pf.Planet()}, preset="earth") as scene:
        moon = pf.Scene("moon", {"planet": pf.Planet(radius_m=1.7374e6)})
        scene.companions.add(moon, pf.Orbit(distance_m=DISTANCE_M, period_s=0.0, inclination_deg=20.0, phase_deg=50.0))
        camera = pf.Camera.at(10.0, -120.0, 500.0, 90.0, 0.0)  # on the side away from the Moon
        app, window, _ = app_of(scene, camera=camera)
        app.dt_s = 1.0 / 30.0
        yield app, window


def heights(app: Any) -> dict[str, float]:
    place = app.camera.position_m
    return {b.name: float(np.linalg.norm(place - b.centre_m)) - b.radius_m for b in bodies(app.scene, app.time_s)}


def test_a_flight_to_the_moon_and_back(flight):
    app, _ = flight
    app.frame()
    for target, name in (("moon", "moon"), ("earth", "earth")):
        app.fly_to_planet(target)
        assert app.planets.crossing is not None and 5.0 < app.planets.crossing.duration_s < 60.0
        before = app.camera
        steps = 0
        while app.planets.crossing is not None:
            app.frame()
            now = app.camera
            steps += 1
            assert steps < 5000 and min(heights(app).values()) > 1.9
            moved = float(np.linalg.norm(now.position_m - before.position_m))
            # By height above the nearer one: at most 1.6 e-folds a second, and around the planet as it climbs.
            assert moved < 0.25 * min(heights(app).values()) + 1e3
            assert float(now.forward @ before.forward) > math.cos(math.radians(12.0))
            before = now
        assert app.planets.name == name
        body = next(b for b in bodies(app.scene, app.time_s) if b.name == name)
        away = body.centre_m - app.camera.position_m
        assert math.isclose(float(np.linalg.norm(away)), 3.0 * body.radius_m, rel_tol=1e-6)
        assert float(app.camera.forward @ away) / float(np.linalg.norm(away)) > 0.9999


def test_place_and_speed_go_on_where_axes_change(flight):
    """By hand, over the place where the Moon becomes the nearest: the way in the scene's axes has no step."""
    app, window = flight
    moon = bodies(app.scene, 0.0)[1]
    ahead = moon.centre_m / DISTANCE_M
    app.place(pf.Camera(ahead * 1.9e8, ahead, (0.0, 0.0, 1.0)))
    assert app.planets.name == "earth"
    window.events.append(KeyEvent("w", True))
    places, speeds, over = [], [], []
    for _ in range(90):
        app.frame()
        places.append(app.camera.position_m)
        speeds.append(app.ship.speed_m_s)
        over.append(app.planets.name)
    assert over[0] == "earth" and over[-1] == "moon"
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    switch = over.index("moon")
    assert np.all(np.diff(steps[switch - 3 : switch + 3]) < 0.2 * steps[switch])  # inertia, and no step
    assert math.isclose(speeds[switch], speeds[switch - 1], rel_tol=0.2)
    assert np.allclose(np.cross(np.array(places) / DISTANCE_M, ahead), 0.0, atol=1e-6)  # straight on


def test_views_and_errors(flight):
    app, _ = flight
    app.place(pf.Camera.at(5.0, 30.0, 1000.0, planet="moon"), pf.Sun(elevation_deg=40.0, latitude_deg=5.0))
    assert app.planets.name == "moon" and math.isclose(heights(app)["moon"], 1000.0, rel_tol=1e-6)
    moon = bodies(app.scene, 0.0)[1]
    assert app.scene.sun.direction is not None  # as the Moon sees it, in the scene's axes
    up = moon.axes @ pf.direction(5.0, 0.0)
    assert math.isclose(float(up @ np.array(app.scene.sun.direction)), math.sin(math.radians(40.0)), rel_tol=1e-6)
    with pytest.raises(pf.UnknownNameError, match="no planet 'mars' to fly to; planets: earth, moon"):
        app.fly_to_planet("mars")
    app.scene.companions.remove("moon")
    app.frame()
    assert app.planets.name == "earth" and heights(app)["earth"] > 1e6


def test_a_place_kept_over_a_moon_that_moves(flight, tmp_path, monkeypatch):
    """Kept at one time and gone to at another: over the same ground, at the first try."""
    monkeypatch.setenv("PLANETFALL_CONFIG", str(tmp_path))
    app, _ = flight
    app.scene.companions["moon"].orbit.period_s = 2.36e6
    app.time_s = 0.0
    app.place(pf.Camera.at(5.0, 30.0, 1000.0, planet="moon"))
    kept = app.pilot.position_m
    app.journey.keep_place("crater")
    app.time_s = 1e5  # the Moon is 1.0e8 m on by then
    app.to_start()
    app.journey.go("crater")
    assert app.time_s == 0.0 and app.planets.name == "moon"
    # Kept in the scene's axes: float64 at 4e8 m has steps of 6e-8 m, and two turns cost some of them.
    assert np.linalg.norm(app.pilot.position_m - kept) < 1e-5


def test_the_suns_clock_over_a_companion(flight):
    app, _ = flight
    app.scene.companions["moon"].orbit.period_s = 2.36e6
    sun = pf.sun_direction(app.scene, app.time_s, pf.Camera.at(0.0, 0.0, 1e3, planet="moon"))
    noon_deg = math.degrees(math.atan2(sun[1], sun[0]))
    app.place(pf.Camera.at(0.0, noon_deg, 1000.0, planet="moon"))
    assert math.isclose(app.journey.hour, 12.0, abs_tol=1e-6)
    app.journey.later(6.0)
    assert math.isclose(app.journey.hour, 18.0, abs_tol=0.01) and "18:00" in app.shown.message
    app.scene.companions.remove("moon")
    assert 0.0 <= app.journey.hour < 24.0  # asked by the overlay before the flight notices


def test_a_preset_loaded_over_a_companion_leaves_the_ship_there(flight, tmp_path, monkeypatch):
    """Only the scene's own planet becomes another one."""
    monkeypatch.setenv("PLANETFALL_PRESETS", str(tmp_path))
    app, _ = flight
    settings = SettingsWindow(app.scene, FrameHistory(4))
    settings.remember(app)
    app.place(pf.Camera.at(5.0, 30.0, 1000.0, planet="moon"))
    before = app.pilot.position_m
    (tmp_path / "shrunk.toml").write_text("[planet]\nradius_m = 5e6\n")
    assert settings.load(app, "shrunk") and app.scene.planet.radius_m == 5e6
    assert app.planets.name == "moon" and np.allclose(app.pilot.position_m, before, atol=1e-3)
