"""Flights to a place: smooth, from space to the ground, never under it; and the pilot that follows them."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from flight_kit import EARTH, pose_at

import planetfall as pf
from planetfall.engine.space import latitude_longitude
from planetfall.systems.flight import FlightInput, FlyTo, Ground, OrbitInput, Pilot, Steering, pose_before
from planetfall.systems.flight.rotation import arc_angle, unit


def angle(a: np.ndarray, b: np.ndarray) -> float:
    return arc_angle(unit(a), unit(b))


@pytest.mark.parametrize(
    ("start", "target"),
    [
        (pose_at(10, 20, 3.6e7, pitch=-90), pose_at(50, 110, 2.0, heading=40)),
        (pose_at(50, 110, 2.0, heading=300), pose_at(50.001, 110.001, 2.0, heading=10, pitch=-10)),
        (pose_at(0, 0, 500.0, pitch=-20), pose_at(0, 180, 500.0, heading=90)),
        (pose_at(5, 5, 1e6, pitch=-90), pose_at(5, 5, 100.0, pitch=-5)),
        (pose_at(89.99, 0, 300.0), pose_at(89.99, 179, 300.0)),
    ],
)
def test_starts_and_ends_where_it_should_and_is_smooth(start, target) -> None:
    route = FlyTo(start, target, Ground(EARTH))
    first, last = route.pose_at(0.0), route.pose_at(route.duration_s)
    np.testing.assert_allclose(first.position_m, start.position_m, rtol=0, atol=1e-5 * (1e5 + EARTH) ** 0.5)
    np.testing.assert_allclose(last.position_m, target.position_m, rtol=0, atol=1.0)
    for found, wanted in ((first, start), (last, target)):
        assert angle(found.forward, wanted.forward) < 1e-6 and angle(found.up, wanted.up) < 1e-6
    times = np.linspace(0.0, route.duration_s, 2001)
    poses = [route.pose_at(t) for t in times]
    heights = np.array([np.linalg.norm(p.position_m) - EARTH for p in poses])
    assert heights.min() >= 2.0 - 1e-8
    turned = np.array([angle(a.forward, b.forward) for a, b in itertools.pairwise(poses)])
    # Never wild: half way around the planet takes more than a second. Steady: no step turns unlike the one before.
    assert turned.max() < 2.5 * route.duration_s / 2000.0
    assert np.abs(np.diff(turned)).max() < 0.1 * turned.max()
    log_heights = np.diff(np.log(heights))
    assert np.abs(np.diff(log_heights)).max() < 0.01  # no kink in the height
    ends = np.linalg.norm(poses[1].position_m - poses[0].position_m)
    assert ends < 1e-4 * np.linalg.norm(start.position_m - target.position_m) + 1.0  # from rest
    assert 0.8 <= route.duration_s <= 20.0


def test_goes_up_to_go_far() -> None:
    near = FlyTo(pose_at(0, 0, 100), pose_at(0, 0.01, 100), Ground(EARTH))
    far = FlyTo(pose_at(0, 0, 100), pose_at(0, 90, 100), Ground(EARTH))

    def top(route: FlyTo) -> float:
        return max(np.linalg.norm(route.pose_at(t).position_m) - EARTH for t in np.linspace(0, route.duration_s, 200))

    # Equation 9 of van Wijk and Nuij, by its limit for ways much longer than both heights: rho^2 / 2 times the way.
    assert top(far) == pytest.approx(1.4**2 / 2.0 * EARTH * math.pi / 2.0, rel=0.05)
    assert 100.0 < top(near) < 1500.0
    assert far.duration_s > near.duration_s


def test_never_below_the_real_ground() -> None:
    rng = np.random.default_rng(4)
    with pf.load_scene("earth") as scene:
        radius, field = scene.planet.radius_m, scene.height_field()
        ground, sampler = Ground(radius, field, 0.0), pf.TerrainSampler(scene)
        for _ in range(12):
            lat, lon = rng.uniform(-80, 80), rng.uniform(-180, 180)
            start = pose_at(lat, lon, 10 ** rng.uniform(0.5, 7), pitch=-30)
            reach = 10 ** rng.uniform(-3, 1.5)
            target = pose_at(np.clip(lat + reach * rng.normal(), -85, 85), lon + reach * rng.normal(), 2.0)
            route = FlyTo(start, target, ground)
            places = np.array([route.pose_at(t).position_m for t in np.linspace(0, route.duration_s, 150)])
            floor = np.maximum(sampler.height(places), 0.0)
            assert (np.linalg.norm(places, axis=1) - radius - floor).min() >= 2.0 - 1e-8


def test_a_place_that_was_pointed_at_ends_in_the_middle() -> None:
    ground = Ground(EARTH)
    point = pose_at(30, 40, 0.0).position_m
    for viewer in (pose_at(25, 35, 1e6), pose_at(30, 40, 1e7)):
        pose = pose_before(ground, point, viewer.position_m, 300.0, 60.0)
        away = point - pose.position_m
        assert np.linalg.norm(away) == pytest.approx(300.0, rel=0.01)
        assert angle(away, pose.forward) < 1e-6
        assert pose.up @ unit(pose.position_m) > 0.8


# the pilot


def pilot(altitude: float = 1000.0, **ground) -> Pilot:
    return Pilot(Ground(EARTH, **ground), pose_at(10, 20, altitude, heading=30.0))


def test_modes_go_on_from_where_the_camera_is() -> None:
    crew = pilot()
    before = crew.pose
    for mode in ("orbit", "ship"):
        crew.switch(mode)
        np.testing.assert_allclose(crew.pose.position_m, before.position_m)
        assert angle(crew.pose.forward, before.forward) < 1e-9
    with pytest.raises(ValueError, match="ship, walk, orbit"):
        crew.switch("swim")  # type: ignore[arg-type]


def test_who_wants_to_walk_is_flown_down_first() -> None:
    crew = pilot(altitude=5000.0)
    crew.switch("walk")
    assert crew.mode == "ship" and crew.route is not None
    for _ in range(2000):
        crew.update(Steering(), 1 / 60)
        if crew.route is None:
            break
    assert crew.mode == "walk" and crew.clearance_m == pytest.approx(1.7, abs=1e-6)
    assert latitude_longitude(crew.position_m)[0] == pytest.approx(10.0, abs=1e-6)
    low = pilot(altitude=5.0)
    low.switch("walk")
    assert low.mode == "walk" and low.route is None


def test_steering_ends_a_flight_and_looking_does_not() -> None:
    crew = pilot(altitude=5000.0)
    crew.fly_to_place(10.5, 20.5, 300.0)
    crew.update(Steering(FlightInput(look_yaw_rad=0.1)), 0.1)
    assert crew.route is not None
    crew.update(Steering(FlightInput(forward=1.0)), 0.1)
    assert crew.route is None
    crew.switch("orbit")
    crew.fly_to_place(-40.0, 170.0, 500.0)
    crew.update(Steering(orbit=OrbitInput(zoom_steps=1.0)), 0.1)
    assert crew.route is None
    crew.fly_to_place(-40.0, 170.0, 500.0)
    for _ in range(1000):
        crew.update(Steering(), 1 / 30)
    latitude, longitude = latitude_longitude(crew.position_m)
    assert (latitude, longitude) == pytest.approx((-40.0, 170.0), abs=1e-6)
    assert crew.mode == "orbit" and crew.clearance_m == pytest.approx(500.0, abs=1e-3)


def test_places_that_cannot_be_are_refused() -> None:
    for bad in ((91.0, 0.0), (math.nan, 0.0), (0.0, math.inf)):
        with pytest.raises(ValueError, match="latitude"):
            pilot().fly_to_place(*bad)


def test_a_point_is_flown_to_from_space_and_from_near() -> None:
    for altitude in (3e7, 500.0):
        crew = pilot(altitude=altitude)
        point = pose_at(10.002, 20.0, 0.0).position_m
        crew.fly_to_point(point)
        for _ in range(2000):
            crew.update(Steering(), 1 / 60)
        away = point - crew.position_m
        assert np.linalg.norm(away) < 7000.0
        assert angle(away, crew.pose.forward) < 1e-5
