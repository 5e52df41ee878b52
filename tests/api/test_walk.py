"""On foot: gravity, steps, slopes, jumps, the sea."""

from __future__ import annotations

import math

import numpy as np
import pytest
from flight_kit import EARTH, Ramp, Step, moved_m, pose_at

import planetfall as pf
from planetfall.systems.flight import FlightInput, Ground, WalkFlight, WalkLimits

DT = 1.0 / 60.0


def walker(ground: Ground, latitude: float = -0.001, **more) -> WalkFlight:
    pose = pose_at(latitude, 0.0, 50.0, radius=ground.radius_m)
    return WalkFlight(ground, pose.position_m, pose.forward, **more)


def go(body: WalkFlight, seconds: float, dt_s: float = DT, **wish) -> None:
    for _ in range(round(seconds / dt_s)):
        body.update(FlightInput(**wish), dt_s)


def test_stands_on_the_ground_and_walks_at_its_pace() -> None:
    body = walker(Ground(EARTH))
    assert np.linalg.norm(body.position_m) - EARTH == pytest.approx(1.7, abs=1e-8)
    start = body.position_m
    go(body, 10.0, forward=1.0)
    # 4 m/s, but for the start: speed runs up as 1 - exp(-t / 0.08 s), which costs 0.08 s of way.
    assert moved_m(start, body.position_m) == pytest.approx(4.0 * (10.0 - 0.08), rel=0.01)
    assert body.position_m[2] > start[2]  # to the north, where it looks
    go(body, 1.0)
    assert body.speed_m_s < 1e-3
    here = body.position_m
    go(body, 1.0, forward=1.0, right=1.0, boost=True)
    assert moved_m(here, body.position_m) == pytest.approx(12.0 * 0.92, rel=0.02)  # no faster on the diagonal


def test_a_jump_is_as_high_as_it_says_on_every_planet() -> None:
    for radius in (EARTH, 1.737e6, 1000.0):
        body = walker(Ground(radius))
        heights = []
        body.update(FlightInput(up=1.0), 1e-3)
        while not body.standing:
            body.update(FlightInput(), 1e-3)
            heights.append(np.linalg.norm(body.position_m) - radius - 1.7)
        # Steps of 1 ms: the first goes up without gravity, which is half a step's climb.
        assert max(heights) == pytest.approx(WalkLimits().jump_m, rel=0.01)
        fall_s = 2.0 * math.sqrt(2.0 * WalkLimits().jump_m / body.gravity_m_s2)
        assert len(heights) * 1e-3 == pytest.approx(fall_s, rel=0.01)
    assert walker(Ground(EARTH)).gravity_m_s2 == pytest.approx(9.81)
    assert walker(Ground(1000.0)).gravity_m_s2 == WalkLimits().least_gravity_m_s2


@pytest.mark.parametrize(("height_m", "climbs"), [(0.3, True), (2.0, False)])
def test_steps(height_m: float, climbs: bool) -> None:
    body = walker(Ground(EARTH, Step(height_m)), latitude=math.degrees(-5.0 / EARTH))
    go(body, 4.0, forward=1.0)
    assert (body.position_m[2] > 0.0) == climbs
    floor = height_m if climbs else 0.0
    assert np.linalg.norm(body.position_m) - EARTH == pytest.approx(floor + 1.7, abs=1e-6)


@pytest.mark.parametrize(("degrees", "climbs"), [(35.0, True), (60.0, False)])
def test_slopes(degrees: float, climbs: bool) -> None:
    field = Ramp(math.tan(math.radians(degrees)))
    body = walker(Ground(EARTH, field), latitude=math.degrees(-5.0 / EARTH))
    go(body, 6.0, forward=1.0)
    assert (body.position_m[2] > 3.0) == climbs
    above = walker(Ground(EARTH, field), latitude=math.degrees(20.0 / EARTH))
    before = above.position_m[2]
    go(above, 1.0)
    assert (above.position_m[2] < before - 0.5) != climbs  # slides down what is too steep to climb


def test_falls_over_an_edge() -> None:
    body = walker(Ground(EARTH, Step(10.0)), latitude=math.degrees(1.0 / EARTH))
    body.update(FlightInput(look_yaw_rad=math.pi), DT)
    seconds = 0.0
    while not (body.standing and body.position_m[2] < 0.0) and seconds < 10.0:
        body.update(FlightInput(forward=1.0), DT)
        seconds += DT
    # A second or so to the edge, and sqrt(2 h / g) = 1.43 s down.
    assert 1.43 < seconds < 2.2
    assert np.linalg.norm(body.position_m) - EARTH == pytest.approx(1.7, abs=1e-6)


def test_swims_floats_dives_and_walks_ashore() -> None:
    ground = Ground(EARTH, Ramp(0.2), sea_level_m=-0.0)
    ground.field = type("Beach", (), {"height": lambda _, d: np.arcsin(d[:, 2]) * EARTH * 0.2, "steepest": 0.2})()
    body = walker(ground, latitude=math.degrees(-50.0 / EARTH))  # ten metres of water
    go(body, 2.0)
    assert body.swimming
    eye = np.linalg.norm(body.position_m) - EARTH
    assert eye == pytest.approx(1.7 - WalkLimits().float_m, abs=0.02)
    go(body, 2.0, up=-1.0)
    assert np.linalg.norm(body.position_m) - EARTH < -2.0
    go(body, 20.0, up=-1.0)
    depth = np.linalg.norm(body.position_m) - EARTH
    assert depth == pytest.approx(-10.0 + 1.7, abs=0.3)  # on the bottom, not below it
    go(body, 10.0, up=1.0)
    assert np.linalg.norm(body.position_m) - EARTH == pytest.approx(0.25, abs=0.1)
    go(body, 40.0, forward=1.0)
    assert not body.swimming and body.standing
    assert body.position_m[2] > -5.0 * WalkLimits().float_m


def test_floats_with_the_waves() -> None:
    height = [0.0]
    body = walker(Ground(EARTH, type("Deep", (), {"height": lambda _, d: np.full(len(d), -50.0)})(), sea_level_m=0.0))
    body.water = lambda up: height[0]
    go(body, 2.0)
    low = np.linalg.norm(body.position_m)
    height[0] = 0.8
    go(body, 3.0)
    assert np.linalg.norm(body.position_m) - low == pytest.approx(0.8, abs=0.05)


def test_nobody_asks_for_waves_inland() -> None:
    asked: list[bool] = []
    for height_m in (500.0, 3.0):
        field = type("Plain", (), {"height": lambda _, d, h=height_m: np.full(len(d), h)})()
        body = walker(Ground(EARTH, field, 0.0), water=lambda up: asked.append(True) or 0.0)
        asked.clear()
        go(body, 0.1, forward=1.0)
        assert bool(asked) == (height_m < 100.0)


def test_walks_on_the_real_ground_and_never_below_it() -> None:
    with pf.load_scene("earth") as scene:
        radius, field = scene.planet.radius_m, scene.height_field()
        ground = Ground(radius, field, 0.0)
        up = pf.direction(49.94822, 112.26272)  # among mountains
        rng = np.random.default_rng(2)
        body = WalkFlight(ground, up * (radius + 9000.0), np.array([0.0, 0.0, 1.0]))
        for _ in range(200):
            wish = FlightInput(
                forward=rng.uniform(-0.2, 1), right=rng.uniform(-1, 1), up=float(rng.integers(5) == 0), boost=True,
                look_yaw_rad=rng.normal(0, 0.2), look_pitch_rad=rng.normal(0, 0.2),
            )  # fmt: skip
            body.update(wish, float(rng.uniform(0.01, 0.2)))
            place = body.position_m
            height = np.linalg.norm(place) - radius - float(field.height((place / np.linalg.norm(place))[None])[0])
            assert height >= 1.7 - 1e-6
            assert abs(body.forward @ body.up) < 1e-12 and np.linalg.norm(body.forward) == pytest.approx(1.0)


def test_frame_times_hardly_matter() -> None:
    ends = []
    for dt_s in (1 / 120, 1 / 60, 1 / 15):
        body = walker(Ground(EARTH, Ramp(0.1)), latitude=0.0001)
        go(body, 4.0, dt_s=dt_s, forward=1.0)
        ends.append(body.position_m)
    assert moved_m(ends[0], ends[1]) < 0.05 and moved_m(ends[1], ends[2]) < 1e-6
    with pytest.raises(ValueError, match="dt_s"):
        walker(Ground(EARTH)).update(FlightInput(), -1.0)


@pytest.mark.gpu
def test_the_drawn_ground_is_where_the_feet_are() -> None:
    with pf.load_scene("earth") as scene, pf.Renderer(scene, (480, 270), "medium") as renderer:
        field = renderer.height_field()
        assert field is not None
        for latitude, longitude in ((49.94822, 112.26272), (20.0, 25.0)):
            up = pf.direction(latitude, longitude)
            body = WalkFlight(Ground(scene.planet.radius_m, field, 0.0), up * 6.4e6, np.array([0.0, 0.0, 1.0]))
            renderer.render(pf.Camera(body.position_m, body.forward, body.up))
            drawn = float(renderer.height_drawn(up[None])[0])
            foot = np.linalg.norm(body.position_m) - scene.planet.radius_m - body.limits.eye_m
            # A pixel of this picture, seen from 1.7 m, is 7 mm of ground; the mesh is to be finer than that.
            assert abs(drawn - foot) < 0.001
