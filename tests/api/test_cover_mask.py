"""Masks of a game's own: where no trees may grow, what is wrong with a mask, clearings and roads, files."""

from __future__ import annotations

import logging
from itertools import pairwise

import numpy as np
import pytest
from cover_kit import PLACE, names_of, woods

import planetfall as pf
from planetfall.engine.frame.gbuffer import Surface

EARTH = pf.Planet().radius_m
EAST = np.cross((0.0, 0.0, 1.0), PLACE)
EAST /= np.linalg.norm(EAST)
NORTH = np.cross(PLACE, EAST)


@pytest.fixture
def scene():
    with woods() as found:
        yield found


def beside(east_m: float, north_m: float) -> np.ndarray:
    """A place near PLACE, planet-centred."""
    return PLACE * EARTH + east_m * EAST + north_m * NORTH


def test_a_mask_takes_trees_and_moves_none(scene):
    cover = scene.planet[pf.Cover]
    before = pf.CoverSampler(scene).within(PLACE, 150.0)
    cover.mask = lambda directions: (directions @ EAST > 0.0).astype(float)
    east = pf.CoverSampler(scene).within(PLACE, 150.0)
    expected = before.only(before.positions_m @ EAST > 0.0)
    assert names_of(east) == names_of(expected) and 100 < len(east) < len(before) - 100
    cover.mask = lambda directions: np.full(len(directions), 0.5)
    half = pf.CoverSampler(scene).within(PLACE, 150.0)
    assert names_of(half) < names_of(before)
    assert len(half) == pytest.approx(0.5 * len(before), abs=4.0 * 0.5 * np.sqrt(len(before)))
    cover.mask = lambda directions: np.ones(len(directions))
    assert names_of(pf.CoverSampler(scene).within(PLACE, 150.0)) == names_of(before)
    cover.mask = None
    assert names_of(pf.CoverSampler(scene).within(PLACE, 150.0)) == names_of(before)


def test_directions_are_unit_and_its_own(scene):
    """What a mask does with its argument changes no tree."""
    before = pf.CoverSampler(scene).within(PLACE, 80.0)
    found = []

    def mask(directions):
        found.append((directions.dtype, directions.shape, np.linalg.norm(directions, axis=1)))
        directions[:] = 7.0
        return np.ones(len(directions), bool)

    scene.planet[pf.Cover].mask = mask
    after = pf.CoverSampler(scene).within(PLACE, 80.0)
    np.testing.assert_array_equal(after.positions_m, before.positions_m)
    assert all(dtype == np.float64 and shape[1:] == (3,) for dtype, shape, _ in found)
    np.testing.assert_allclose(np.concatenate([length for _, _, length in found]), 1.0, atol=1e-12)


def test_the_picture_follows_a_mask(scene):
    view = pf.view("forest", scene.planet)
    overrides = {"cover.reach_m": 80.0, "composite.antialiasing": "none"}
    with pf.Renderer(scene, size=(96, 54), quality="low", overrides=overrides) as renderer:
        renderer.settle(view)
        assert (renderer.render(view, outputs=("surface",))["surface"] == Surface.COVER).mean() > 0.2
        eye = renderer.camera_state(view).position_m
        scene.planet[pf.Cover].mask = pf.clearing(eye, 500.0)
        renderer.settle(view)
        assert (renderer.render(view, outputs=("surface",))["surface"] != Surface.COVER).all()
        scene.planet[pf.Cover].mask = None
        renderer.settle(view)
        assert (renderer.render(view, outputs=("surface",))["surface"] == Surface.COVER).mean() > 0.2


# -- what is wrong with a mask ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("mask", "message"),
    [
        (3, r"Cover\.mask: expected a function, or nothing, found 3. Assign one in Python"),
        (lambda d: 1.0, r"Cover\.mask: the function '<lambda>' has to give one number from 0 to 1 .*found shape \(\)"),
        (lambda d: d, r"found shape \(3, 3\)\. Return an array \(N,\)"),
        (lambda d: np.full(len(d), 1.5), r"found 1\.5 for directions\[0\] = .*Clip it"),
        (lambda d: np.full(len(d), np.nan), r"found nan for directions\[0\]"),
        (lambda d: "all", r"found 'all'\. Return an array"),
        (lambda d: None, r"found shape \(\)|found None"),
    ],
)
def test_a_wrong_mask_is_refused_where_it_is_assigned(scene, mask, message):
    cover = scene.planet[pf.Cover]
    with pytest.raises(pf.SettingError, match=message):
        cover.mask = mask
    assert cover.mask is None


def test_one_that_goes_wrong_later_says_where(scene):
    """Right at first, and wrong for places of trees: the error comes with the first trees."""
    scene.planet[pf.Cover].mask = lambda d: np.where(d @ PLACE > 0.999, 2.0, 1.0)
    with pytest.raises(
        ValueError, match=r"Cover\.mask: .* for each of \d+ directions \(N, 3\), found 2 for directions\[0\]"
    ):
        pf.CoverSampler(scene).within(PLACE, 80.0)


def test_its_own_error_comes_through(scene):
    def mask(directions):
        if len(directions) > 3:
            raise KeyError("my map is not loaded")
        return np.ones(len(directions))

    scene.planet[pf.Cover].mask = mask
    with pytest.raises(KeyError, match="my map is not loaded"):
        pf.CoverSampler(scene).within(PLACE, 80.0)


# -- files -----------------------------------------------------------------------------------------------------------


def test_saving_says_that_a_mask_is_left_out(scene, tmp_path, caplog):
    scene.planet[pf.Cover].mask = pf.clearing(beside(0.0, 0.0), 30.0)
    with caplog.at_level(logging.WARNING):
        scene.save(tmp_path / "a.toml")
    assert "not saved, as no file can hold a function: Cover.mask; assign it again after load_scene" in caplog.text
    with pf.load_scene(tmp_path / "a.toml") as again:
        assert again.planet[pf.Cover].mask is None
    caplog.clear()
    scene.planet[pf.Cover].mask = None
    scene.save(tmp_path / "a.toml")
    assert not caplog.records


def test_a_file_cant_have_one(tmp_path):
    path = tmp_path / "b.toml"
    path.write_text('base = "woods"\n[cover]\nmask = "roads"\n')
    with pytest.raises(
        pf.PresetError, match=r"cover\.mask: expected a function, or nothing, found 'roads'. Assign one in"
    ):
        pf.load_scene(path)


# -- clearings and roads ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("planet_m", [500.0, EARTH, 7e7])
def test_a_clearing_is_as_wide_as_it_says(planet_m):
    mask = pf.clearing(PLACE * planet_m, 40.0)
    for away_m, share in ((0.0, 0.0), (39.9, 0.0), (40.1, 1.0), (400.0, 1.0)):
        angle = away_m / planet_m
        turn = np.linspace(0.0, 6.0, 20)[:, None]
        around = np.cos(angle) * PLACE + np.sin(angle) * (np.cos(turn) * EAST + np.sin(turn) * NORTH)
        np.testing.assert_array_equal(mask(around), share)


def test_a_road_is_as_wide_as_it_says():
    """Straight and around a bend, near and in the middle of a stretch of 60 km."""
    points = np.stack([beside(0.0, 0.0), beside(30_000.0, 0.0), beside(30_000.0, 60_000.0)])
    points *= (EARTH / np.linalg.norm(points, axis=1))[:, None]
    mask = pf.road(points, 8.0)
    for a, b in pairwise(points):
        side = np.cross(a, b)
        side /= np.linalg.norm(side)
        for share in (0.001, 0.2, 0.5, 0.9):
            middle = a + share * (b - a)
            middle /= np.linalg.norm(middle)
            for away_m, open_ in ((0.0, 0.0), (3.9, 0.0), (-3.9, 0.0), (4.1, 1.0), (-4.1, 1.0), (900.0, 1.0)):
                place = middle + away_m / EARTH * side
                assert mask((place / np.linalg.norm(place))[None])[0] == open_, (share, away_m)
    # One by one and together they are the same; the end of a road is round.
    around = PLACE + np.random.default_rng(3).normal(size=(500, 3)) * (6.0 / EARTH)
    around /= np.linalg.norm(around, axis=1)[:, None]
    together = mask(around)
    np.testing.assert_array_equal(together, [mask(one[None])[0] for one in around])
    assert 0.1 < together.mean() < 0.9


def test_no_tree_stands_on_a_road(scene):
    points = np.stack([beside(-90.0, -80.0), beside(0.0, 0.0), beside(90.0, -30.0)])
    before = pf.CoverSampler(scene).within(PLACE, 100.0)
    road, house = pf.road(points, 6.0), pf.clearing(beside(20.0, 40.0), 15.0)
    scene.planet[pf.Cover].mask = lambda directions: road(directions) * house(directions)
    after = pf.CoverSampler(scene).within(PLACE, 100.0)
    feet = before.positions_m * (EARTH / np.linalg.norm(before.positions_m, axis=1))[:, None]
    x, y = (feet - PLACE * EARTH) @ EAST, (feet - PLACE * EARTH) @ NORTH
    away = np.full(len(feet), np.inf)
    corners = np.array([(-90.0, -80.0), (0.0, 0.0), (90.0, -30.0)])
    for a, b in pairwise(corners):
        flat = np.stack([x, y], axis=1) - a
        share = np.clip(flat @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
        away = np.minimum(away, np.linalg.norm(flat - share[:, None] * (b - a), axis=1))
    free = (away > 3.0) & (np.hypot(x - 20.0, y - 40.0) > 15.0)
    assert names_of(after) == names_of(before.only(free)) and len(before) - len(after) > 20


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: pf.clearing(PLACE, 20.0),
            r"radius_m: .*found 20.0; multiply a unit direction by scene\.planet\.radius_m",
        ),
        (lambda: pf.clearing(PLACE * EARTH, -1.0), r"radius_m: expected metres above 0"),
        (lambda: pf.clearing(PLACE * EARTH, np.nan), r"radius_m: expected metres above 0"),
        (lambda: pf.clearing([0.0, 0.0, 0.0], 1.0), r"place_m\[0\]: expected finite metres, not the centre"),
        (lambda: pf.clearing(np.eye(3) * EARTH, 1.0), r"place_m: expected one place \(3,\), found 3"),
        (
            lambda: pf.road(PLACE * EARTH, 3.0),
            r"points_m: expected two points or more, found 1; .* pf\.clearing",
        ),
        (
            lambda: pf.road([[1.0, 2.0]], 3.0),
            r"points_m: expected planet-centred metres \(N, 3\), found shape \(1, 2\)",
        ),
        (
            lambda: pf.road([PLACE * EARTH, PLACE * np.nan], 3.0),
            r"points_m\[1\]: expected finite metres",
        ),
        (lambda: pf.road("up", 3.0), r"points_m: expected planet-centred metres \(N, 3\), found 'up'"),
    ],
)
def test_bad_clearings_and_roads_are_named(call, message):
    with pytest.raises(ValueError, match=message):
        call()
