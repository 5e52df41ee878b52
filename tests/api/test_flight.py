"""The ship and the scripted paths: never under ground, smooth, deterministic, at the promised speeds."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np
import pytest

from planetfall.engine.input import InputState, KeyEvent, MouseMove, Wheel
from planetfall.engine.settings.check import PresetError
from planetfall.engine.space import direction, heading_pitch_axes
from planetfall.systems.flight import (
    CruisePath,
    FlightInput,
    GroundProfile,
    KeyFrame,
    KeyFramePath,
    ShipFlight,
    ShipLimits,
    find_path,
    flight_input,
    load_paths,
)
from planetfall.systems.flight.path import MonotoneCubic
from planetfall.systems.flight.rotation import arc_angle, carry, exp_map, log_map, slerp, turn, unit

EARTH = 6.371e6


class Hills:
    """A cheap field with steep slopes on every scale from 100 km to 100 m."""

    def height(self, directions: np.ndarray) -> np.ndarray:
        total = np.zeros(len(directions))
        for wavelength_m, amplitude_m in ((1e5, 3000.0), (7e3, 600.0), (500.0, 60.0), (90.0, 8.0)):
            phase = directions * (2.0 * math.pi * EARTH / wavelength_m)
            total += amplitude_m * np.sin(phase[:, 0]) * np.cos(phase[:, 1] + 1.0) * np.cos(phase[:, 2])
        return total


def clearance(position: np.ndarray, field: Hills | None, sea: float | None = None, radius: float = EARTH) -> float:
    ground = 0.0 if field is None else float(field.height(unit(position)[None, :])[0])
    return float(np.linalg.norm(position)) - radius - (ground if sea is None else max(ground, sea))


def ship(
    latitude: float = 10.0, longitude: float = 20.0, altitude: float = 2.0, pitch: float = 0.0, **more
) -> ShipFlight:
    up = direction(latitude, longitude)
    radius = more.pop("radius_m", EARTH)
    forward, ship_up = heading_pitch_axes(up, 30.0, pitch)
    return ShipFlight(up * (radius + altitude), forward, ship_up, radius_m=radius, **more)


# the sphere


def test_arcs_are_accurate_at_every_size() -> None:
    base = unit(np.array([0.3, -0.5, 0.8]))
    for angle in (1e-12, 1e-6, 1.0, 3.1):
        tangent = angle * unit(np.cross(base, np.array([0.0, 0.0, 1.0])))
        there = exp_map(base, tangent)
        assert arc_angle(base, there) == pytest.approx(angle, rel=1e-3 if angle < 1e-9 else 1e-9)
        np.testing.assert_allclose(log_map(base, there), tangent, atol=1e-15 + 1e-9 * angle)
        middle = slerp(base, there, 0.5)
        assert arc_angle(base, middle) == pytest.approx(0.5 * angle, rel=1e-3 if angle < 1e-9 else 1e-9)
        np.testing.assert_allclose(carry(base, base, there), there, atol=1e-15)
    x, z = np.array([1.0, 0, 0]), np.array([0, 0, 1.0])
    np.testing.assert_allclose(turn(x, z, math.pi / 2), [0, 1, 0], atol=1e-15)
    with pytest.raises(ValueError, match="finite length above zero"):
        unit(np.zeros(3))


# the ship


def test_never_below_the_ground() -> None:
    field, rng = Hills(), np.random.default_rng(3)
    flyer = ship(altitude=500.0, pitch=-30.0, field=field, sea_level_m=0.0)
    lowest = math.inf
    for _ in range(400):
        wish = FlightInput(
            forward=rng.uniform(-1, 1), right=rng.uniform(-1, 1), up=rng.uniform(-1, 0.2),
            look_yaw_rad=rng.normal(0, 0.1), look_pitch_rad=rng.normal(-0.02, 0.1), boost=bool(rng.integers(2)),
            wheel_steps=float(rng.integers(-1, 2)),
        )  # fmt: skip
        flyer.update(wish, float(rng.uniform(0.005, 0.4)))
        lowest = min(lowest, clearance(flyer.position_m, field, 0.0))
        assert abs(flyer.forward @ flyer.up) < 1e-12 and abs(np.linalg.norm(flyer.up) - 1) < 1e-12
    assert lowest >= flyer.limits.clearance_m - 1e-8


def test_starting_under_ground_is_lifted() -> None:
    assert ship(altitude=-3000.0).altitude_m == pytest.approx(2.0, abs=1e-8)
    flyer = ship(altitude=0.0, field=Hills(), limits=ShipLimits(clearance_m=5.0))
    assert clearance(flyer.position_m, Hills()) >= 5.0 - 1e-8


def test_same_inputs_same_flight() -> None:
    ends = []
    for _ in range(2):
        flyer = ship(altitude=1000.0, field=Hills())
        for step in range(60):
            flyer.update(FlightInput(forward=1.0, look_yaw_rad=0.01 * math.sin(step), roll=0.5), 0.03)
        ends.append(np.concatenate([flyer.position_m, flyer.forward, flyer.up]))
    assert np.array_equal(*ends)


def test_hardly_depends_on_the_frame_rate() -> None:
    ends = []
    for rate in (30, 60, 240):
        flyer = ship(altitude=1e5, pitch=-20.0)
        for _ in range(3 * rate):
            flyer.update(FlightInput(forward=1.0), 1.0 / rate)
        ends.append(flyer.position_m)
    travelled = np.linalg.norm(ends[1] - ship(altitude=1e5).position_m)
    assert np.linalg.norm(ends[0] - ends[1]) < 1e-9 * EARTH
    assert np.linalg.norm(ends[2] - ends[1]) < 0.02 * travelled


def test_speed_follows_the_height() -> None:
    for altitude in (2.0, 1e3, 1e6, 3.6e7):
        flyer = ship(altitude=altitude)
        for _ in range(120):
            flyer.update(FlightInput(right=1.0), 1 / 60)
        now = flyer.clearance_m
        assert flyer.speed_m_s == pytest.approx(flyer.top_speed_m_s(now), rel=0.1)
    assert ship().top_speed_m_s(2.0) == ShipLimits().slowest_m_s
    assert ship().top_speed_m_s(1e4, boost=True) == 5.0 * ship().top_speed_m_s(1e4)
    assert ship().top_speed_m_s(1e12) == ShipLimits().fastest_m_s


def test_from_space_to_the_ground_and_no_overshoot() -> None:
    flyer = ship(altitude=3.6e7, pitch=-90.0, field=Hills())
    seconds = 0.0
    while flyer.clearance_m > 3.0 and seconds < 90:
        flyer.update(FlightInput(forward=1.0), 0.05)
        seconds += 0.05
    assert 15 < seconds < 60


def test_wheel_sets_the_throttle_within_limits() -> None:
    flyer = ship(altitude=1e4)
    flyer.update(FlightInput(wheel_steps=2.0), 0.01)
    assert flyer.throttle == pytest.approx(1.25**2)
    flyer.update(FlightInput(wheel_steps=-500.0), 0.01)
    assert flyer.throttle == 1 / ShipLimits().wheel_range


def test_it_drifts_to_rest() -> None:
    flyer = ship(altitude=1000.0)
    flyer.update(FlightInput(forward=1.0), 0.5)
    assert flyer.speed_m_s > 100
    for _ in range(60):
        flyer.update(FlightInput(), 0.05)
    assert flyer.speed_m_s < 1.0


def test_level_flight_follows_the_curve_and_rights_itself() -> None:
    flyer = ship(altitude=100.0, limits=ShipLimits(slowest_m_s=3e3))
    for _ in range(600):
        flyer.update(FlightInput(forward=1.0), 0.1)
    moved = arc_angle(direction(10.0, 20.0), flyer.local_up)
    assert moved > math.radians(1)
    assert abs(flyer.forward @ flyer.local_up) < 1e-3
    flyer.update(FlightInput(roll=1.0), 0.5)
    assert -(flyer.right @ flyer.local_up) > 0.2
    for _ in range(100):
        flyer.update(FlightInput(), 0.1)
    assert abs(flyer.right @ flyer.local_up) < 1e-3


def test_look_right_and_up() -> None:
    flyer = ship(altitude=100.0)
    forward, right = flyer.forward, flyer.right
    flyer.update(FlightInput(look_yaw_rad=0.2), 0.0)
    assert flyer.forward @ right == pytest.approx(math.sin(0.2), abs=1e-6)
    flyer.update(FlightInput(look_yaw_rad=-0.2, look_pitch_rad=0.1), 0.0)
    assert flyer.forward @ flyer.local_up == pytest.approx(math.sin(0.1), abs=1e-6)
    assert flyer.forward @ forward == pytest.approx(math.cos(0.1), abs=1e-6)


@pytest.mark.parametrize("radius", [1e3, 7e7])
def test_small_and_large_planets(radius: float) -> None:
    flyer = ship(altitude=2.0, radius_m=radius)
    for _ in range(50):
        flyer.update(FlightInput(forward=1.0, boost=True), 0.1)
    assert flyer.altitude_m > 1.95
    assert np.isfinite(flyer.position_m).all()


def test_bad_vectors_are_refused() -> None:
    for bad in ([0, 0, 0], [math.nan, 0, 1]):
        with pytest.raises(ValueError, match="finite length"):
            ShipFlight([EARTH, 0, 0], bad, radius_m=EARTH)
        with pytest.raises(ValueError, match="finite length"):
            ShipFlight(bad, [0, 0, 1], radius_m=EARTH)
    with pytest.raises(ValueError, match="radius_m"):
        ShipFlight([1, 0, 0], [0, 0, 1], radius_m=-1)
    with pytest.raises(ValueError, match="dt_s"):
        ship().update(FlightInput(), math.nan)
    straight_up = ShipFlight([EARTH + 5, 0, 0], [1, 0, 0], radius_m=EARTH)
    assert abs(straight_up.up @ straight_up.forward) < 1e-12


def test_keys_become_wishes() -> None:
    state = InputState()
    state.advance([KeyEvent("w", True), KeyEvent("left_shift", True), MouseMove(0, 0, 10, -5), Wheel(0, 2)])
    wish = flight_input(state, looking=True)
    assert wish.forward == 1.0 and wish.boost and wish.wheel_steps == 2
    assert wish.look_yaw_rad > 0 and wish.look_pitch_rad > 0
    assert flight_input(state, looking=False).look_yaw_rad == 0.0
    state.consume(keyboard=True)
    assert flight_input(state, looking=True).forward == 0.0


# the paths


def test_monotone_cubic_keeps_monotone_and_smooth() -> None:
    curve = MonotoneCubic([0, 1, 2, 5, 6], [0, 0.1, 5, 5, 2])
    x = np.linspace(0, 6, 601)
    y = np.array([curve(v) for v in x])
    assert (np.diff(y[:200]) >= -1e-12).all() and np.ptp(y[200:500]) < 1e-12 and y.max() <= 5 + 1e-12
    assert [curve(v) for v in (0, 1, 2, 5, 6)] == pytest.approx([0, 0.1, 5, 5, 2])
    slope = np.diff(y) / np.diff(x)
    assert np.abs(np.diff(slope)).max() < 0.5  # a kink would be 4.9


def test_presets_load() -> None:
    paths = load_paths()
    assert set(paths) >= {"descent", "low"}
    assert all(path.help and path.sun for path in paths.values())


def test_descent_starts_in_space_and_ends_at_eye_height() -> None:
    field = Hills()
    path = find_path("descent").over(EARTH, field, sea_level_m=0.0)
    assert clearance(path.pose_at(0.0).position_m, field, 0.0) == pytest.approx(3.6e7, rel=1e-3)
    assert clearance(path.pose_at(path.duration_s).position_m, field, 0.0) == pytest.approx(2.0, abs=0.01)
    heights = [clearance(path.pose_at(t).position_m, field, 0.0) for t in path.times_s(200)]
    assert min(heights) >= path.path.clearance_m - 1e-8
    assert all(b < 1.05 * a + 5000 for a, b in itertools.pairwise(heights))


def test_low_keeps_its_speed_and_height() -> None:
    field = Hills()
    path = find_path("low").over(EARTH, field, sea_level_m=0.0)
    poses = [path.pose_at(t) for t in np.arange(0, 60, 0.1)]
    heights = [clearance(pose.position_m, field, 0.0) for pose in poses]
    assert min(heights) >= 99.0
    places = [unit(pose.position_m) for pose in poses]
    speeds = [arc_angle(a, b) * EARTH / 0.1 for a, b in itertools.pairwise(places)]
    np.testing.assert_allclose(speeds, 300.0, rtol=1e-6)
    over_sea = find_path("low").over(EARTH)
    assert clearance(over_sea.pose_at(30.0).position_m, None) == pytest.approx(100.0, abs=1e-6)


def test_paths_are_smooth_at_their_keys() -> None:
    """Position, altitude and look have a continuous first derivative: the slopes on both sides of a key agree."""
    path = find_path("descent")
    assert isinstance(path, KeyFramePath)
    h = 1e-4
    for key in path.keys[1:-1]:
        t = key.time_s
        for of in (lambda s: path.track(s, EARTH), lambda s: np.array([math.log(path.height_above(s))])):
            left = (of(t) - of(t - h)) / h
            right = (of(t + h) - of(t)) / h
            scale = max(float(np.linalg.norm(left)), float(np.linalg.norm(right)), 1e-9)
            assert np.linalg.norm(left - right) < 0.01 * scale + 1e-8
        assert path.height_above(t) == pytest.approx(key.altitude_m, rel=1e-9)


def test_paths_are_deterministic_and_clamped() -> None:
    first, second = (find_path("descent").over(EARTH, Hills()) for _ in range(2))
    for t in (0.0, 12.3, 59.0):
        assert np.array_equal(first.pose_at(t).position_m, second.pose_at(t).position_m)
    assert np.array_equal(first.pose_at(-5.0).forward, first.pose_at(0.0).forward)
    assert np.array_equal(first.pose_at(1e9).position_m, first.pose_at(first.duration_s).position_m)
    camera = first.camera_at(30.0)
    assert np.array_equal(np.asarray(camera.position_m), first.pose_at(30.0).position_m)


def test_profile_is_an_envelope_that_meets_the_ground_at_its_ends() -> None:
    field = Hills()
    cruise = CruisePath("x", latitude_deg=5, longitude_deg=5, heading_deg=80, speed_m_s=300)

    def track(times: np.ndarray) -> np.ndarray:
        return np.stack([cruise.track(float(t), EARTH) for t in times])

    profile = GroundProfile(track, 60.0, field, window_s=4.0)
    ground = field.height(track(profile.times_s))
    assert (profile.heights_m >= ground - 1e-9).all()
    assert profile.heights_m[[0, -1]] == pytest.approx(ground[[0, -1]])
    rough, smooth = (np.abs(np.diff(h, 2)).mean() for h in (ground, profile.heights_m))
    assert smooth < 0.5 * rough


def test_heading_across_north_takes_the_short_way() -> None:
    path = KeyFramePath("x", keys=(KeyFrame(0, 0, 0, 10, heading_deg=350), KeyFrame(1, 0, 0, 10, heading_deg=10)))
    north = path.look(0.5, direction(0, 0), EARTH)[0]
    np.testing.assert_allclose(north, [0, 0, 1], atol=1e-9)


def test_path_files_say_what_is_wrong(tmp_path: Path) -> None:
    file = tmp_path / "paths.toml"
    common = '[path.a]\nkind = "keys"\nlatitude_deg = 1.0\nlongitude_deg = 2.0\n'
    for text, message in (
        (
            common + "keys = [{ time_s = 0, altitude_m = 5, hight = 2 }]",
            r"paths\.toml: path\.a\.keys\[0\]: unknown key 'hight'; .*keys: altitude_m",
        ),
        (common.replace("keys", "cruise") + "speed = 3.0", r"path\.a: unknown key 'speed'; did you mean 'speed_m_s'\?"),
        (
            common + "sun = { elevation = 3.0 }",
            r"path\.a\.sun: unknown key 'elevation'; did you mean 'elevation_deg'\?",
        ),
        (common.replace("keys", "cruize"), r"path\.a\.kind: Invalid value 'cruize'"),
        (
            common + "keys = [{ time_s = 0, altitude_m = inf }, { time_s = 1, altitude_m = 5 }]",
            r"keys\[0\]\.altitude_m",
        ),
        (common + "keys = [{ time_s = 0, altitude_m = 5, heading_deg = nan }]", r"path\.a\.keys\[0\]\.heading_deg"),
        (common + "keys = [{ time_s = 0, altitude_m = 5 }]", "two or more key frames"),
        ("path = 3", r"path: expected tables \[path\.NAME\], found 3"),
        (common + "keys = [{ time_s = 0, altitude_m = -5 }]", r"keys\[0\]\.altitude_m.*>? ?0"),
        (common + "keys = []", "keys"),
        (
            common + "keys = [{ time_s = 1, altitude_m = 5 }]",
            r"path\.a\.keys: two or more key frames need ascending times from 0 s",
        ),
        (common + 'keys = [{ time_s = "soon", altitude_m = 5 }]', r"time_s: Expected `float`, got `str`"),
        ("[path", "not valid TOML"),
        ('base = "earth"\n', r"expected flights, tables \[path\.NAME\].* found 'base'\. A scene file is no flight"),
        ("", "found nothing of the kind"),
    ):
        file.write_text(text)
        with pytest.raises(PresetError, match=message):
            load_paths(file)
    with pytest.raises(PresetError, match="did you mean 'descent'"):
        find_path("decent")
    with pytest.raises(PresetError, match="no such file"):
        load_paths(tmp_path / "none.toml")


def test_the_ground_is_asked_for_once_a_step_and_not_at_rest() -> None:
    """Heights are most of what a frame of flight costs."""
    asked: list[int] = []

    class Counted(Hills):
        def height(self, directions: np.ndarray) -> np.ndarray:
            asked.append(len(directions))
            return super().height(directions)

    flyer = ship(altitude=1e5, field=Counted())
    asked.clear()
    for _ in range(10):
        flyer.update(FlightInput(), 1.0 / 60.0)
        assert flyer.clearance_m > 0.0
    assert asked == []
    for _ in range(10):
        flyer.update(FlightInput(forward=1.0), 1.0 / 60.0)
        assert flyer.clearance_m > 0.0
    assert asked == [2] * 10  # here and a little ahead
    flyer.ground.field = Counted()  # a knob was turned
    asked.clear()
    flyer.update(FlightInput(), 1.0 / 60.0)
    assert asked
