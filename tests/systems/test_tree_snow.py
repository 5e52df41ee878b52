"""Snow on trees: who carries how much when and where, that near and far ones agree, and that no tree is another."""

from __future__ import annotations

import numpy as np
import pytest
from cover_kit import woods

import planetfall as pf
from planetfall.benchmarks.measure.forests import Pair, mean_light
from planetfall.engine.frame.gbuffer import Surface
from planetfall.systems.cover.growth import Growing
from planetfall.systems.cover.snow import SnowFall

EARTH_M = 6.371e6
GROWING = Growing.of(pf.Terrain(), 0.0)


def place(latitude_deg: float, height_m: float = 0.0) -> np.ndarray:
    a = np.deg2rad(latitude_deg)
    return (EARTH_M + height_m) * np.array([[np.cos(a), 0.0, np.sin(a)]])


def carried(latitude_deg: float, season: float, height_m: float = 0.0, keeps: float = 1.0) -> float:
    return float(SnowFall(GROWING, EARTH_M, keeps, season).on(place(latitude_deg, height_m))[0])


def test_it_lies_where_it_is_cold():
    assert carried(5.0, 0.0) == carried(5.0, 0.5) == 0.0
    # Under the snow line of the tropics all year, at 55 degrees in winter alone.
    assert carried(5.0, 0.0, 5000.0) == carried(5.0, 0.5, 5000.0) > 0.8
    assert carried(55.0, 0.0) > 0.9 and carried(55.0, 0.5) == 0.0
    assert carried(55.0, 0.0, keeps=0.0) == 0.0 and carried(55.0, 0.0, keeps=0.4) == pytest.approx(0.4)
    heights = np.linspace(0.0, 4000.0, 200)
    found = np.array([carried(46.0, 0.0, h) for h in heights])
    assert (np.diff(found) >= 0.0).all() and np.diff(found).max() < 0.05 and found[-1] == 1.0


def test_the_year_has_no_jumps_and_the_south_is_half_of_it_apart():
    year = np.linspace(0.0, 1.0, 1001)
    for latitude in (35.0, 47.0, 60.0):
        found = np.array([carried(latitude, float(t)) for t in year])
        assert np.abs(np.diff(found)).max() < 0.03 and found[0] == pytest.approx(found[-1])
        south = np.array([carried(-latitude, float((t + 0.5) % 1.0)) for t in year])
        np.testing.assert_allclose(found, south, atol=1e-9)


def test_far_forests_carry_as_much(run_compute):
    rng = np.random.default_rng(2)
    sine, height = rng.uniform(-1.0, 1.0, 2000), rng.uniform(0.0, 5000.0, 2000)
    points = (EARTH_M + height)[:, None] * np.stack([np.sqrt(1.0 - sine**2), np.zeros(2000), sine], axis=1)
    for season in (0.0, 0.2, 0.5, 0.9):
        snow = SnowFall(GROWING, EARTH_M, 0.7, season)
        north, south = snow.winters()
        out = run_compute(
            f"white = snow_share(0.7, vec2({north:.8f}, {south:.8f}), warmth, sine);",
            {"warmth": GROWING.warmth(sine, height).astype(np.float32), "sine": sine.astype(np.float32)},
            {"white": "float"},
            header='#include "cover/snow_share.glsl"',
        )
        # Of a ramp 0.12 wide.
        np.testing.assert_allclose(out["white"], snow.on(points), atol=2e-5)


def test_no_tree_is_another():
    with woods() as scene:
        eye = pf.view("treeline", scene.planet).camera.resolve(scene).position_m
        found = []
        for snow in (0.0, 1.0):
            scene.planet[pf.Cover].snow = snow
            found.append(pf.CoverSampler(scene).within(eye, 150.0))
    for name in ("names", "positions_m", "heights_m", "species"):
        np.testing.assert_array_equal(getattr(found[0], name), getattr(found[1], name))


@pytest.fixture(scope="module")
def pictures():
    """Albedo of trees and which pixels show them, by season and snow."""
    found = {}
    with woods() as scene:
        overrides = {"cover.reach_m": 300.0, "composite.antialiasing": "none"}
        with pf.Renderer(scene, size=(160, 90), quality="low", overrides=overrides) as renderer:
            for season, snow in ((0.0, 0.0), (0.0, 1.0), (0.5, 0.0)):
                scene.planet[pf.Cover].season, scene.planet[pf.Cover].snow = season, snow
                view = pf.view("treeline", scene.planet)
                renderer.settle(view)
                out = renderer.render(view, outputs=("albedo", "surface"))
                found[season, snow] = out["albedo"].copy(), out["surface"] == Surface.COVER
    return found


def test_conifers_are_white_in_winter(pictures):
    white, bare = pictures[0.0, 1.0], pictures[0.0, 0.0]
    np.testing.assert_array_equal(white[1], bare[1])
    snowy = white[0][white[1]].min(axis=-1) > 0.4
    assert 0.25 < snowy.mean() < 0.9 and not (bare[0][bare[1]].min(axis=-1) > 0.4).any()


@pytest.mark.parametrize("variety", [0.0, 1.0])
def test_light_stays_where_far_forests_take_over(variety):
    """Of the two ways in which a forest in snow is drawn, in pairs of a sun and a view."""
    pairs = (Pair(60.0, 35.0, 60.0), Pair(25.0, 35.0, 60.0))
    with woods() as scene:
        cover = scene.planet[pf.Cover]
        cover.season, cover.snow, cover.variety = 0.0, 1.0, variety
        near, far, flat = (
            mean_light(scene, "treeline", {"cover.reach_m": reach, "cover.crowns": crowns}, pairs, "low")[:, 1]
            for reach, crowns in ((900.0, 4), (20.0, 4), (20.0, 0))
        )
        cover.snow = 0.0
        green = mean_light(scene, "treeline", {"cover.reach_m": 900.0}, pairs, "low")[:, 1]
    assert (near > 1.3 * green).all()
    np.testing.assert_allclose(far / near, 1.0, atol=0.15)
    np.testing.assert_allclose(flat / near, 1.0, atol=0.15)
