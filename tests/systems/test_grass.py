"""Grass: that it shows near the camera, covers as much whatever its blades, and fades into the ground's own colour."""

from __future__ import annotations

import numpy as np
import pytest
from cover_kit import woods

import planetfall as pf
from planetfall.engine.frame.gbuffer import Surface

SIZE = (240, 135)


@pytest.fixture(scope="module")
def scene():
    with woods() as found:
        found.planet[pf.Cover].flowers = 0.0
        yield found


def ground(scene, quality="medium", view="meadow", size=SIZE, **overrides):
    """Radiance, distance, which pixels show ground, and their height, of one frame."""
    overrides = {"cover.reach_m": 60.0, "composite.antialiasing": "none", "terrain.shade_every": 1, **overrides}
    seen = pf.view(view, scene.planet)
    with pf.Renderer(scene, size=size, quality=quality, overrides=overrides) as renderer:
        renderer.settle(seen)
        out = renderer.render(seen, outputs=("radiance", "surface", "distance", "position"))
        place = out["position"].astype(np.float64) + renderer.camera_state(seen).position_m
        height = np.linalg.norm(place, axis=-1) - scene.planet[pf.Planet].radius_m
        return out["radiance"].copy(), out["distance"].copy(), out["surface"] == Surface.TERRAIN, height


@pytest.fixture(scope="module")
def bare(scene):
    scene.planet[pf.Cover].grass = 0.0
    found = ground(scene)
    scene.planet[pf.Cover].grass = 1.0
    return found


@pytest.mark.parametrize("blades", [1, 3, 6, 12])
def test_the_ground_keeps_its_brightness(scene, bare, blades):
    """Blades are brighter than what lies between them is darker: the mean stays within a tenth, whatever their number,
    and at the distance where they end within a hundredth, so that nobody sees where that is."""
    radiance, distance, shown, _ = ground(scene, **{"cover.blades": blades})
    for near_m, far_m, most in ((0.0, 6.0, 0.1), (6.0, 15.0, 0.1), (25.0, 60.0, 0.01)):
        part = shown & bare[2] & (distance > near_m) & (distance < far_m)
        ratio = radiance[part].mean() / bare[0][part].mean()
        assert abs(ratio - 1.0) < most, (near_m, ratio)


def test_blades_show(scene, bare):
    radiance, distance, shown, _ = ground(scene)
    near = shown & bare[2] & (distance < 6.0)
    changed = np.abs(radiance / bare[0] - 1.0).max(axis=-1)
    assert (changed[near] > 0.1).mean() > 0.12
    assert changed[shown & bare[2] & (distance > 100.0)].max(initial=0.0) == 0.0


def test_they_stand_upright(scene, bare):
    """What grass adds to the picture differs less along blades than across them."""
    scene.planet[pf.Wind].speed_m_s = 0.0
    try:
        radiance, distance, shown, _ = ground(scene, **{"cover.blades": 9})
    finally:
        scene.planet[pf.Wind].speed_m_s = 8.0
    light = np.log(radiance.mean(axis=-1) / bare[0].mean(axis=-1))
    near = shown & bare[2] & (distance < 5.0)
    across = np.abs(np.diff(light, axis=1))[near[:, 1:] & near[:, :-1]].mean()
    along = np.abs(np.diff(light, axis=0))[near[1:] & near[:-1]].mean()
    assert across > 1.05 * along


def test_flowers_have_colours_of_their_own(scene):
    plain, _, shown, _ = ground(scene)
    scene.planet[pf.Cover].flowers = 1.0
    try:
        flowery, distance, _, _ = ground(scene)
    finally:
        scene.planet[pf.Cover].flowers = 0.0
    changed = shown & (np.abs(flowery / plain - 1.0).max(axis=-1) > 0.3)
    near = shown & (distance < 8.0)
    assert 0.002 < changed[near].mean() < 0.2
    share = flowery[changed] / flowery[changed].sum(axis=-1, keepdims=True)
    assert np.ptp(share[:, 0]) > 0.2 and np.ptp(share[:, 2]) > 0.2


def test_none_grows_on_a_beach(scene):
    scene.planet[pf.Cover].grass = 0.0
    without = ground(scene, view="beach", size=(576, 324))
    scene.planet[pf.Cover].grass = 1.0
    with_grass = ground(scene, view="beach", size=(576, 324))
    low_m = scene.planet[pf.Ocean].sea_level_m + 0.4 * scene.planet[pf.Terrain].beach_height_m
    sand = without[2] & with_grass[2] & (without[1] < 12.0) & (without[3] < low_m)
    assert sand.sum() > 500
    assert (np.abs(with_grass[0] / without[0] - 1.0).max(axis=-1)[sand] > 0.02).mean() < 0.05
