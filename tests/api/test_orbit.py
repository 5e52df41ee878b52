"""The globe in the hand: what was grabbed stays under the pointer, zoom goes to it, nothing goes below the ground."""

from __future__ import annotations

import math

import numpy as np
import pytest
from flight_kit import EARTH, Flat, pose_at

import planetfall as pf
from planetfall.systems.flight import Ground, OrbitFlight, OrbitInput


def globe(ground: Ground | None = None, altitude: float = 1e7, pitch: float = -90.0) -> OrbitFlight:
    pose = pose_at(20.0, 30.0, altitude, pitch=pitch)
    return OrbitFlight(ground or Ground(EARTH), pose.position_m, pose.forward, pose.up)


def pixel_of(view: OrbitFlight, point: np.ndarray, wish: OrbitInput) -> tuple[float, float]:
    """Where a point is in the picture, -1..1: worked out from the axes, not from the code under test."""
    away = point - view.position_m
    depth, half = away @ view.forward, math.tan(math.radians(wish.fov_y_deg) / 2.0)
    return float(away @ np.cross(view.forward, view.up) / depth / half / wish.aspect), float(
        away @ view.up / depth / half
    )


@pytest.mark.parametrize("altitude", [1e7, 1e5, 3e3])
def test_what_was_grabbed_stays_under_the_pointer(altitude: float) -> None:
    view = globe(altitude=altitude)
    at, wish = (0.1, 0.2), OrbitInput()
    grabbed = view.under(at, wish)
    assert grabbed is not None and np.linalg.norm(grabbed) == pytest.approx(EARTH)
    for to in ((0.2, 0.25), (0.3, -0.1), (-0.2, 0.1)):
        view.update(OrbitInput(pointer=to, pointer_before=at, drag=True), 1 / 60)
        at = to
        assert pixel_of(view, grabbed, wish) == pytest.approx(to, abs=1e-6)
    assert np.linalg.norm(view.position_m) == pytest.approx(EARTH + altitude)


def test_a_globe_that_is_let_go_turns_on_and_stops() -> None:
    view = globe()
    view.update(OrbitInput(pointer=(0.1, 0.0), pointer_before=(0.0, 0.0), drag=True), 1 / 60)
    before = view.position_m
    for _ in range(30):
        view.update(OrbitInput(), 1 / 60)
    assert np.linalg.norm(view.position_m - before) > 1e5
    for _ in range(600):
        view.update(OrbitInput(), 1 / 60)
    rest = view.position_m
    view.update(OrbitInput(), 1 / 60)
    assert np.array_equal(view.position_m, rest)
    view.update(OrbitInput(pointer=(0.1, 0.0), pointer_before=(0.0, 0.0), drag=True), 1 / 60)
    view.update(OrbitInput(pointer=(0.1, 0.0), pointer_before=(0.1, 0.0), drag=True), 1 / 60)
    held = view.position_m
    view.update(OrbitInput(), 1 / 60)
    assert np.array_equal(view.position_m, held)  # held still before it was let go


def test_zoom_goes_to_the_pointer_and_keeps_it_there() -> None:
    view = globe()
    at = (0.25, -0.2)
    wish = OrbitInput(pointer=at)
    target = view.under(at, wish)
    assert target is not None
    distance = np.linalg.norm(view.position_m - target)
    for step in range(600):
        view.update(OrbitInput(pointer=at, zoom_steps=2.0 if step % 60 == 0 else 0.0), 1 / 60)
    assert np.linalg.norm(view.position_m - target) == pytest.approx(distance * 0.8**20, rel=0.01)
    assert pixel_of(view, target, wish) == pytest.approx(at, abs=0.01)
    for step in range(900):
        view.update(OrbitInput(pointer=at, zoom_steps=-5.0 if step % 60 == 0 else 0.0), 1 / 60)
    assert np.linalg.norm(view.position_m) <= 60.0 * EARTH * 1.01


def test_always_above_the_ground() -> None:
    with pf.load_scene("earth") as scene:
        ground = Ground(scene.planet.radius_m, scene.height_field(), 0.0)
        view, rng = globe(ground, altitude=2e4, pitch=-40.0), np.random.default_rng(1)
        at = (0.0, 0.0)
        lowest = math.inf
        for step in range(300):
            to = tuple(rng.uniform(-1, 1, 2).tolist())
            wish = OrbitInput(
                pointer=to, pointer_before=at, drag=step % 3 == 0, tilt=step % 7 == 0, zoom_steps=rng.uniform(-1, 3),
                forward=rng.uniform(-1, 1), right=rng.uniform(-1, 1), turn=rng.uniform(-1, 1), lean=rng.uniform(-1, 1),
            )  # fmt: skip
            view.update(wish, float(rng.uniform(0.01, 0.2)))
            at = to
            lowest = min(lowest, ground.clearance(view.position_m))
            assert abs(view.forward @ view.up) < 1e-9
            assert np.linalg.norm(view.forward) == pytest.approx(1.0, abs=1e-9)
        assert lowest >= 2.0 - 1e-8


def test_tilt_keeps_the_middle_and_stops_at_the_horizon() -> None:
    view = globe(Ground(EARTH, Flat(500.0)), altitude=1e4)
    middle = view.under((0.0, 0.0), OrbitInput())
    assert middle is not None and np.linalg.norm(middle) == pytest.approx(EARTH + 500.0)
    for _ in range(3):
        view.update(OrbitInput(pointer=(0.05, -0.1), tilt=True), 1 / 60)
        again = view.under((0.0, 0.0), OrbitInput())
        assert again is not None and np.linalg.norm(again - middle) < 1.0
    for _ in range(100):
        view.update(OrbitInput(lean=1.0), 1 / 20)
    up = view.position_m / np.linalg.norm(view.position_m)
    assert -0.35 < view.forward @ up < 0.0
    assert view.clearance_m >= 2.0 - 1e-8


def test_keys_move_the_globe_at_a_pace_of_its_height() -> None:
    for altitude in (1e3, 1e6):
        view = globe(altitude=altitude)
        before = view.position_m / np.linalg.norm(view.position_m)
        for _ in range(60):
            view.update(OrbitInput(forward=1.0), 1 / 60)
        after = view.position_m / np.linalg.norm(view.position_m)
        assert after[2] > before[2]  # to the north, which is up in the picture
        share = np.linalg.norm(after - before) * (EARTH + altitude) / altitude
        assert share == pytest.approx(0.5, rel=0.01)
    with pytest.raises(ValueError, match="dt_s"):
        globe().update(OrbitInput(), math.nan)


def test_the_sky_is_nothing_to_grab() -> None:
    view = globe(altitude=3.6e7)
    assert view.under((0.99, 0.99), OrbitInput()) is None
    before = view.position_m
    view.update(OrbitInput(pointer=(0.99, 0.99), pointer_before=(0.98, 0.99), drag=True), 1 / 60)
    assert np.array_equal(view.position_m, before)
