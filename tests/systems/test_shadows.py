"""Shadows of the ground and its shelter from the sky: the clipmap's geometry, what runs when, and rays in float64."""

from __future__ import annotations

import math

import numpy as np
import pytest

import planetfall as pf
from planetfall.benchmarks.measure import shadows
from planetfall.components import Terrain
from planetfall.systems.shadows.stereographic import PROJECTIONS, nearest_projection
from planetfall.systems.shadows.windows import Reach, Windows, reach_of

EARTH_M = 6.371e6
SIZE = (320, 180)


def unit(rng, count):
    v = rng.normal(size=(count, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


# -- geometry --------------------------------------------------------------------------------------------------------


def test_places_on_the_projection_come_back_and_lengths_scale_alike_in_all_directions():
    rng = np.random.default_rng(1)
    for direction in unit(rng, 40):
        projection = nearest_projection(direction)
        assert projection.axes[2] @ direction >= 1.0 / math.sqrt(3.0) - 1e-12  # a corner of the cube at worst
        place = projection.place(direction)
        assert np.abs(projection.direction(place) - direction).max() < 1e-14
        step = 1e-6
        for turn in rng.uniform(0.0, 2.0 * np.pi, 3):
            other = projection.direction(place + step * np.array([np.cos(turn), np.sin(turn)]))
            assert np.linalg.norm(other - direction) == pytest.approx(step * projection.scale(place), rel=1e-5)


def test_a_projection_is_kept_until_another_is_clearly_nearer():
    border = np.array([1.0, 1.0, 0.0]) / math.sqrt(2.0)
    for held in (PROJECTIONS[0], PROJECTIONS[2]):
        assert nearest_projection(border, held) is held
    assert nearest_projection(np.array([0.6, 0.8, 0.0]), PROJECTIONS[0]) is PROJECTIONS[2]


def test_axes_of_projections_are_right_handed():
    for projection in PROJECTIONS:
        assert np.allclose(np.cross(projection.axes[0], projection.axes[1]), projection.axes[2])


def covered(windows, level):
    """The texels of the planet that a level's memory holds, as its corner and wrapping say."""
    x, y = np.meshgrid(*(np.arange(windows.size) + c for c in level.corner))
    return set(zip(x.ravel().tolist(), y.ravel().tolist(), strict=True))


def test_windows_ask_for_exactly_the_texels_that_they_lack():
    rng = np.random.default_rng(2)
    windows = Windows(64, 16)
    foot = PROJECTIONS[4].place(np.array([0.3, 0.2, 0.9]) / np.linalg.norm([0.3, 0.2, 0.9]))
    held: dict[int, set[tuple[int, int]]] = {}
    for _ in range(200):
        foot = foot + rng.normal(size=2) * 10.0 ** rng.uniform(-7.0, -4.0)
        reach = Reach(PROJECTIONS[4], foot, 22, 10)
        assert windows.follow(reach, 20)
        assert [level.power for level in windows.levels] == list(range(10, 23))
        for level in windows.levels:
            before = held.get(level.power, set())
            parts = [(x, y) for px, py, w, h in level.fresh for x in range(px, px + w) for y in range(py, py + h)]
            assert len(parts) == len(set(parts))
            new = {(x + level.corner[0], y + level.corner[1]) for x, y in parts}
            now = covered(windows, level)
            assert new == now - (before if len(new) < 64 * 64 else set())
            held[level.power] = now
            level.fresh, level.shift = [], (0, 0)
            middle = [math.ldexp(float(v), level.power) - c for v, c in zip(foot, level.corner, strict=True)]
            assert all(windows.half <= m <= 64 - windows.half for m in middle)


def test_a_sweep_covers_all_that_a_shift_lets_see_further():
    windows = Windows(128, 16)
    foot = np.array([0.2, 0.1])
    reach = Reach(PROJECTIONS[4], foot, 20, 20)
    windows.follow(reach, 20)
    level = windows.levels[0]
    level.fresh, level.swept = [], 3
    for shift in ((16, 0), (-16, 0), (0, 32), (16, -16)):
        for turn in np.linspace(0.0, 2.0 * np.pi, 9)[:-1]:
            level.shift = shift
            way = np.array([np.cos(turn), np.sin(turn)])
            way = way / np.abs(way).max()
            made = np.zeros((128, 128), bool)
            for x, y, w, h in windows.unlit(level, 3, way, 32):
                made[y : y + h, x : x + w] = True
            # Texels whose way of 32 steps ends inside the window now, and was outside it or not there before.
            y, x = np.mgrid[0:128, 0:128]
            old_x, old_y = x + shift[0], y + shift[1]
            was = (old_x >= 0) & (old_x < 128) & (old_y >= 0) & (old_y < 128)
            for steps in (0, 8, 16, 31):
                inside = [(p + steps * v >= 0) & (p + steps * v <= 127) for p, v in zip((x, y), way, strict=True)]
                before = [
                    (p + steps * v >= 0) & (p + steps * v <= 127) for p, v in zip((old_x, old_y), way, strict=True)
                ]
                further = inside[0] & inside[1] & ~(before[0] & before[1])
                assert not (~made & (~was | further)).any()


@pytest.mark.parametrize("radius_m", [500.0, 1.0e4, EARTH_M, 7.0e7])
@pytest.mark.parametrize("altitude_m", [0.5, 100.0, 1.0e4, 2.0e6, 3.6e7, 1.0e9])
def test_the_levels_reach_from_the_nearest_pixel_to_the_horizon(radius_m, altitude_m):
    direction = np.array([0.6, -0.5, 0.62])
    direction /= np.linalg.norm(direction)
    reach = reach_of(
        direction, altitude_m, altitude_m, 2e-3, radius_m, (-1e-3 * radius_m, 1e-3 * radius_m), 192, 0.5, 0.75, None
    )
    assert reach.finest - reach.coarsest < 20
    metre = 1.0 / (radius_m * reach.projection.scale(reach.foot))
    finest_m = math.ldexp(1.0, -reach.finest) / metre
    widest = math.ldexp(192 / 2 - 14, -reach.coarsest)
    assert finest_m < 2.0 * max(2e-3 * altitude_m / 0.75, 0.5) or reach.finest == reach.coarsest
    horizon = math.acos(radius_m / (radius_m + altitude_m))
    rng = np.random.default_rng(3)
    for turn in rng.uniform(0.0, 2.0 * np.pi, 20):
        side = np.cross(direction, [0.0, 0.0, 1.0])
        side /= np.linalg.norm(side)
        other = np.cross(direction, side)
        seen = direction * np.cos(horizon) + (side * np.cos(turn) + other * np.sin(turn)) * np.sin(horizon)
        assert np.abs(reach.projection.place(seen) - reach.foot).max() <= widest


@pytest.mark.parametrize("above_m", [0.0, 1e-9, 1e-6, 1e-3, 1.0])
def test_a_camera_on_a_sea_that_hides_all_ground(above_m):
    """Found by `planetfall stress frame`: without horizon or summit there is nothing that a shadow could fall from."""
    sea, summits = 12461.257810666002, 11328.4
    direction = np.array([0.0, -1.0, 1.0]) / math.sqrt(2.0)
    reach = reach_of(direction, sea + above_m, above_m, 2e-3, 1.9e6, (sea, summits), 192, 0.5, 0.75, None)
    assert reach.coarsest <= reach.finest and reach.finest - reach.coarsest < 20
    assert math.ldexp(1.0, -reach.finest) * 1.9e6 * reach.projection.scale(reach.foot) >= 0.5


# -- on the GPU ------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def scene():
    return pf.load_scene("earth")


@pytest.fixture(scope="module")
def renderer(scene):
    with pf.Renderer(scene, size=SIZE, quality="medium") as made:
        yield made


def low_sun(renderer, view, elevation_deg, azimuth_deg=None):
    state = renderer.camera_state(view)
    latitude, longitude = pf.latitude_longitude(state.position_m / np.linalg.norm(state.position_m))
    azimuth = view.sun.azimuth_deg if azimuth_deg is None else azimuth_deg
    return pf.Sun(
        elevation_deg=elevation_deg, azimuth_deg=azimuth, latitude_deg=float(latitude), longitude_deg=float(longitude)
    )


def sideways(renderer, view, step_m, count):
    state = renderer.camera_state(view)
    return [
        pf.Camera(state.position_m + (state.right * 0.8 + state.direction * 0.1) * step_m * k, state.forward, state.up)
        for k in range(count)
    ]


@pytest.mark.parametrize(
    ("name", "elevation_deg", "most"),
    # From 10 km gullies are as wide as a texel or two: the bench finds 0.073.
    [("valley", 14.0, 0.06), ("near", 8.0, 0.06), ("high", 10.0, 0.15), ("terminator", 6.0, 0.06)],
)
def test_shadows_are_where_rays_to_the_sun_are_hidden(renderer, name, elevation_deg, most):
    view = pf.view(name)
    found = shadows.shadow_error(renderer, view, np.random.default_rng(4), 250, low_sun(renderer, view, elevation_deg))
    # A texel is as wide as 1.3 to 4 pixels: places nearer than that to a shadow's edge may be on the other side of it.
    # Twice what the bench finds with 1000 places at 640 x 360.
    assert found.wrong < most
    assert found.mean < most


def test_a_window_that_moved_holds_what_a_new_one_would(renderer):
    view = pf.view("valley")
    sun = low_sun(renderer, view, 14.0)
    cameras = sideways(renderer, view, 10.0, 24)
    renderer.settle(cameras[0], sun=sun)
    for camera in cameras:
        renderer.render(camera, sun=sun, dt_s=1.0 / 60.0)
    own = renderer.views[0].found(renderer.system("shadows"))
    moved = own.textures[-1].read()
    corners = {level.power: level.corner for level in own.windows.levels}
    renderer.settle(cameras[-1], sun=sun)
    renderer.render(cameras[-1], sun=sun)
    fresh = own.textures[-1].read()
    size, side = own.windows.size, own.windows.side
    old, new = (np.frombuffer(data, np.float32).reshape(-1, side, side, 4) for data in (moved, fresh))
    compared = 0
    for level in own.windows.levels:
        x, y = (np.arange(size) + c for c in level.corner)
        # Both windows' texels, well inside: nearer to the edge the coarser level stands in for what lies outside.
        keep = [
            (p >= corners[level.power][a] + 40) & (p < corners[level.power][a] + size - 40)
            & (p >= level.corner[a] + 40) & (p < level.corner[a] + size - 40)
            for a, p in enumerate((x, y))
        ]  # fmt: skip
        rows, columns = (y % side)[keep[1]], (x % side)[keep[0]]
        layer = own.windows.layer(level)
        a, b = (data[layer][np.ix_(rows, columns)] for data in (old, new))
        # Heights are right to 0.6 mm from any anchor, 9 km in f32 to 0.5 mm; places in f32 to 2e-7 of their distance.
        texel_m = 2.0 * EARTH_M * 2.0**-level.power
        assert np.abs(a[..., 0] - b[..., 0]).max() < 2e-3 + 2e-7 * size * texel_m
        assert np.quantile(np.abs(a[..., 1:3] - b[..., 1:3]), 0.999) < 2e-3 + 0.02 * texel_m
        compared += a.size
    assert compared > 1000


def test_it_runs_only_when_something_moved_and_turning_is_not_that(renderer):
    view = pf.view("valley", "earth")
    renderer.settle(view)
    renderer.render(view)
    renderer.render(view)
    passes = {p.name: p for p in renderer.passes()}
    assert not passes["shadows.clipmap"].ran
    state = renderer.camera_state(view)
    turned = pf.Camera(state.position_m, state.right, state.up, fov_y_deg=50.0)
    renderer.render(turned, sun=view.sun)
    assert not {p.name: p for p in renderer.passes()}["shadows.clipmap"].ran


@pytest.mark.parametrize(("frames", "dt_s"), [(20, 1.0 / 60.0), (1, None)])
def test_a_sun_that_moves_is_followed_within_some_frames_and_at_once_in_a_single_picture(renderer, frames, dt_s):
    view = pf.view("valley")
    renderer.settle(view, sun=low_sun(renderer, view, 30.0))
    sun = low_sun(renderer, view, 14.0)
    for _ in range(frames):
        renderer.render(view, sun=sun, dt_s=dt_s)
    own = renderer.system("shadows")
    assert own.settled(renderer.views[0])
    late = np.frombuffer(renderer.views[0].found(own).textures[-1].read(), np.float32)
    renderer.settle(view, sun=sun)
    renderer.render(view, sun=sun)
    assert np.array_equal(late, np.frombuffer(renderer.views[0].found(own).textures[-1].read(), np.float32))


def test_a_single_picture_from_elsewhere_has_its_own_shadows(renderer):
    """After a leap of 90 km and another sun: nothing of the map that was there is left."""
    view = pf.view("valley")
    renderer.settle(view, sun=low_sun(renderer, view, 8.0, 60.0))
    away = pf.Camera.at(3.2, 145.3, 300.0, heading_deg=200.0, pitch_deg=-10.0, above="ground")
    sun = low_sun(renderer, view, 20.0, 300.0)
    renderer.render(away, sun=sun)
    assert renderer.system("shadows").settled(renderer.views[0])


def test_without_shadows_nothing_runs_and_nothing_is_kept(scene):
    terrain = scene.planet[Terrain]
    with pf.Renderer(scene, size=(64, 36), quality="low") as made:
        view = pf.view("valley")
        made.render(view)
        assert "shadows.map" in made.graph.resources
        terrain.shadows = terrain.occlusion = False
        try:
            made.render(view)
            assert not any(p.name.startswith("shadows.") for p in made.passes())
            assert not any(name.startswith("shadows.") for name in made.graph.resources)
        finally:
            terrain.shadows = terrain.occlusion = True
        made.render(view)
        assert any(p.name == "shadows.clipmap" and p.ran for p in made.passes())


@pytest.mark.parametrize("kept", ["shadows", "occlusion"])
def test_each_of_the_two_is_left_out_alone(scene, kept):
    terrain = scene.planet[Terrain]
    off = "occlusion" if kept == "shadows" else "shadows"
    view = pf.view("high")
    try:
        setattr(terrain, off, False)
        with pf.Renderer(scene, size=SIZE, quality="medium") as made:
            sun = low_sun(made, view, 10.0)
            made.settle(view, sun=sun)
            places = shadows.spots(made, view, np.random.default_rng(9), 400, sun)
            with shadows.LightProbe(made) as probe:
                sun_share, sky_share = probe(places.seen_m).T
    finally:
        setattr(terrain, off, True)
    dark, sheltered = (sun_share < 0.5).mean(), (sky_share < 0.98).mean()
    assert (dark > 0.02) == (kept == "shadows")
    assert (sheltered > 0.02) == (kept == "occlusion")


def test_points_in_the_air_leave_the_shadow_where_the_ray_passes_the_crest(renderer):
    view = pf.view("valley")
    sun = low_sun(renderer, view, 6.0, 200.0)
    renderer.settle(view, sun=sun)
    places = shadows.spots(renderer, view, np.random.default_rng(7), 200, sun)
    up = places.points_m / np.linalg.norm(places.points_m, axis=1, keepdims=True)
    lifts = 10.0 ** np.random.default_rng(6).uniform(1.5, 4.0, len(up))
    lifted = shadows.Spots(
        places.points_m + up * lifts[:, None],
        places.seen_m + up * lifts[:, None],
        places.normals,
        places.sun,
        places.radius_rad,
    )
    true = shadows.seen_share(renderer, lifted)
    with shadows.LightProbe(renderer) as probe:
        ours = probe(lifted.seen_m)[:, 0]
    assert 0.2 < true.mean() < 0.9
    # Twice what is found.
    assert np.abs(ours - true).mean() < 0.06


def test_far_points_have_the_planets_own_shadow(renderer):
    view = pf.view("terminator")
    renderer.settle(view)
    renderer.render(view)
    state, sun = renderer.camera_state(view), renderer.frame.sun.direction
    rng = np.random.default_rng(7)
    points = unit(rng, 4000) * EARTH_M * rng.uniform(1.02, 4.0, (4000, 1))
    points = points[points @ state.direction > 0.1 * EARTH_M]  # altitudes are known in the camera's hemisphere
    along = points @ sun
    beside = np.linalg.norm(points - along[:, None] * sun, axis=1)
    with shadows.LightProbe(renderer) as probe:
        seen = probe(points - state.position_m)[:, 0]
    # Off the penumbra, twice as wide as the disc; the highest ground; and what a shadow's height, R / cos - R over
    # 0.6 rad, bends between texels 250 km apart (second derivative times an eighth of their square: 4 km), three times.
    clear = np.abs(beside - EARTH_M) > 0.01 * np.abs(along) + 9e3 + 3 * 4e3
    hidden = (along < 0.0) & (beside < EARTH_M)
    assert hidden[clear].sum() > 20
    assert np.array_equal(seen[clear] < 0.5, hidden[clear])


def test_shelter_from_the_sky_is_what_rays_find(renderer):
    view = pf.view("high")
    renderer.settle(view)
    places = shadows.spots(renderer, view, np.random.default_rng(8), 40)
    true = shadows.open_share(renderer, places)
    with shadows.LightProbe(renderer) as probe:
        ours = probe(places.seen_m)[:, 1]
    # 192 rays a place are right to 0.005.
    assert np.abs(ours - true).mean() < 0.6 * np.abs(1.0 - true).mean() + 0.005
