"""Seasons of the ground: where and when snow lies, that trees follow, and that summer is as it was."""

from __future__ import annotations

import numpy as np
import pytest
from cover_kit import woods

import planetfall as pf
from planetfall.components.season import in_season, winter_at
from planetfall.engine.frame.gbuffer import Surface


def test_shader_and_python_have_one_winter(run_compute):
    sine = np.linspace(-1.0, 1.0, 4001)
    for season in (0.0, 0.15, 0.5, 0.8, 1.0):
        north, south = winter_at(season, np.array([1.0, -1.0]))
        out = run_compute(
            f"winter = winter_here(vec2({north:.9f}, {south:.9f}), sine);",
            {"sine": sine.astype(np.float32)},
            {"winter": "float"},
            header='#include "common/season.glsl"',
        )
        np.testing.assert_allclose(out["winter"], winter_at(season, sine), atol=2e-6)


def test_trees_have_the_grounds_season_or_their_own():
    cover, ground = pf.Cover(), pf.Terrain(season=0.1)
    assert in_season(cover, pf.Terrain()) is cover and not winter_at(None, np.array([0.9, -0.9])).any()
    assert in_season(cover, ground).season == 0.1 and cover.season == 0.5
    cover.season = 0.8
    assert in_season(cover, ground) is cover


@pytest.fixture(scope="module")
def pictures():
    """Albedo (90, 160, 3) and what shows (90, 160) of some views, by name and season."""
    found = {}
    with woods() as scene:
        overrides = {"cover.reach_m": 400.0, "composite.antialiasing": "none"}
        with pf.Renderer(scene, size=(160, 90), quality="low", overrides=overrides) as renderer:
            for name in ("treeline", "grove"):
                view = pf.view(name, scene.planet)
                for season in (None, 0.5, 0.0, 1.0, 0.2):
                    scene.planet[pf.Terrain].season = season
                    renderer.settle(view)
                    out = renderer.render(view, outputs=("albedo", "surface"))
                    found[name, season] = out["albedo"].copy(), out["surface"].copy()
    return found


def white(pictures, name: str, season: float | None, surface: Surface) -> float:
    """Share of a picture's pixels of that surface that snow has made white."""
    albedo, shown = pictures[name, season]
    return float((albedo[shown == surface].min(axis=-1) > 0.4).mean())


def test_snow_lies_on_ground_and_trees_in_winter_alone(pictures):
    for surface, least in ((Surface.TERRAIN, 0.4), (Surface.COVER, 0.1)):
        assert white(pictures, "treeline", 0.0, surface) > least > white(pictures, "treeline", 0.2, surface)
        assert white(pictures, "treeline", 0.5, surface) < 0.05
    # Summer is as ground without seasons.
    np.testing.assert_array_equal(pictures["treeline", None][0], pictures["treeline", 0.5][0])
    # New Year's Eve is New Year's Day.
    np.testing.assert_array_equal(pictures["treeline", 0.0][0], pictures["treeline", 1.0][0])


def test_no_tree_stands_elsewhere(pictures):
    shown = [pictures["treeline", season][1] == Surface.COVER for season in (0.5, 0.0)]
    np.testing.assert_array_equal(*shown)


def test_the_tropics_have_no_winter(pictures):
    np.testing.assert_array_equal(pictures["grove", 0.5][0], pictures["grove", 0.0][0])


def test_snow_buries_no_forest():
    """Far away, where the ground's own colour has the trees in it, snow between them leaves them as many: a forest in
    winter is darker than open snow."""
    with woods() as scene:
        scene.planet[pf.Terrain].season = 0.0
        overrides = {"cover.reach_m": 20.0, "cover.crowns": 0, "composite.antialiasing": "none"}
        found = []
        for density in (1.0, 0.0):
            scene.planet[pf.Cover].density = density
            with pf.Renderer(scene, size=(160, 90), quality="low", overrides=overrides) as renderer:
                view = pf.view("treeline", scene.planet)
                renderer.settle(view)
                out = renderer.render(view, outputs=("albedo", "surface"))
                found.append(out["albedo"][out["surface"] == Surface.TERRAIN].mean())
    assert found[0] < 0.8 * found[1]
