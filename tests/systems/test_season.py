"""Seasons: which leaves turn and fall where and when, and that pictures show it."""

from __future__ import annotations

import numpy as np
import pytest
from cover_kit import woods

import planetfall as pf
from planetfall.engine.frame.gbuffer import Surface
from planetfall.systems.cover.season import SUMMER, leaves_at

YEAR = np.linspace(0.0, 1.0, 2001)


def sine(latitude_deg: float) -> float:
    return float(np.sin(np.deg2rad(latitude_deg)))


@pytest.mark.parametrize("latitude_deg", [-90.0, -45.0, -30.0, 0.0, 23.0, 31.5, 40.0, 90.0])
def test_leaves_go_gradually_all_year(latitude_deg):
    """New Year's included: no step is larger than the steepest ramp makes, but when bare trees have no leaves left
    whose colour could be seen."""
    found = [leaves_at(float(t), sine(latitude_deg)) for t in YEAR]
    turned, bare = np.array(found).T
    assert ((turned >= 0.0) & (turned <= 1.0) & (bare >= 0.0) & (bare <= 1.0)).all()
    step = YEAR[1] / 0.1 * 1.01
    assert np.abs(np.diff(bare)).max() <= step and bare[0] == pytest.approx(bare[-1])
    colour = turned * (1.0 - bare)
    assert np.abs(np.diff(colour)).max() <= 2.0 * step and colour[0] == pytest.approx(colour[-1])


def test_the_tropics_keep_theirs_and_the_south_is_half_a_year_apart():
    assert all(leaves_at(float(t), sine(latitude)) == SUMMER for t in YEAR for latitude in (0.0, 22.9, -22.9))
    for t in (0.1, 0.3, 0.5, 0.75, 0.9):
        assert leaves_at(t, 0.8) == pytest.approx(leaves_at((t + 0.5) % 1.0, -0.8))
    assert leaves_at(0.5, 0.8) == SUMMER
    assert leaves_at(0.81, 0.8).turned == 1.0 and leaves_at(0.0, 0.8).bare == 1.0


@pytest.fixture(scope="module")
def pictures():
    """Radiance and which pixels show trees, by season."""
    found = {}
    with woods() as scene:
        overrides = {"cover.reach_m": 150.0, "composite.antialiasing": "none"}
        with pf.Renderer(scene, size=(160, 90), quality="low", overrides=overrides) as renderer:
            for season in (0.5, 0.8, 0.0):
                scene.planet[pf.Cover].season = season
                view = pf.view("woodland", scene.planet)
                renderer.settle(view)
                for _ in range(2):  # shadows of leaves that have fallen
                    out = renderer.render(view, outputs=("radiance", "surface"))
                found[season] = out["radiance"].copy(), out["surface"] == Surface.COVER
    return found


def test_autumn_is_red_and_gold(pictures):
    share = {}
    for season, (radiance, trees) in pictures.items():
        colour = radiance[trees]
        share[season] = np.median(colour[:, 0] / colour.sum(axis=1))
    assert share[0.8] > 1.25 * share[0.5] and share[0.8] > share[0.0] > share[0.5]


def test_in_winter_more_of_the_sky_shows(pictures):
    covered = {season: trees.mean() for season, (_, trees) in pictures.items()}
    assert covered[0.8] == pytest.approx(covered[0.5], abs=0.01) and covered[0.0] < 0.97 * covered[0.5]


def test_an_override_reaches_it():
    """As `planetfall render --set cover.season=0.8` has it."""
    red = []
    for change in ({}, {"cover.season": 0.8}):
        overrides = {"cover.reach_m": 60.0, **change}
        with woods() as scene, pf.Renderer(scene, (96, 54), "low", overrides=overrides) as renderer:
            view = pf.view("woodland", scene.planet)
            renderer.settle(view)
            picture = renderer.render(view)["color"].astype(float)
            red.append(picture[..., 0].mean() / picture.mean())
    assert red[1] > 1.05 * red[0]


def test_forests_seen_from_space_turn_where_they_shed():
    """Each place by its own latitude, wherever the camera is."""
    seen = {}
    with (
        woods() as scene,
        pf.Renderer(scene, (240, 135), "low", overrides={"composite.antialiasing": "none"}) as renderer,
    ):
        camera = pf.Camera.at(35.0, 140.0, 1.2e7, pitch_deg=-90.0)
        sun = pf.Sun(elevation_deg=70.0, azimuth_deg=180.0, latitude_deg=35.0, longitude_deg=140.0)
        for season in (0.5, 0.79):
            scene.planet[pf.Cover].season = season
            renderer.settle(camera)
            out = renderer.render(camera, sun=sun, outputs=("radiance", "position", "surface"))
            seen[season] = {name: value.copy() for name, value in out.items()}
        place = seen[0.5]["position"] + renderer.camera_state(camera).position_m
    land = seen[0.5]["surface"] == Surface.TERRAIN
    north = place[..., 2] / np.linalg.norm(place, axis=-1)
    turned = seen[0.79]["radiance"] / seen[0.5]["radiance"]
    redder = turned[..., 0] / turned[..., 1]
    tropics, temperate = land & (abs(north) < 0.38), land & (north > 0.65)
    assert tropics.sum() > 200 and temperate.sum() > 200
    assert np.abs(redder[tropics] - 1.0).max() < 1e-3
    assert (redder[temperate] > 1.05).mean() > 0.05 and (redder[temperate] > 0.98).all()
