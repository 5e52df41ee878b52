"""Trees: where they stand, that they are drawn there, what they shade, and that nothing is there without them."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest
from cover_kit import woods

import planetfall as pf
from planetfall.engine.blocks.bindings import MATERIAL_BLOCK, PLANET_BLOCK
from planetfall.engine.frame.block import PlanetBlock
from planetfall.engine.frame.gbuffer import Surface
from planetfall.engine.surface.lattice import cell_edge_m, cell_of
from planetfall.engine.wavelengths import GIVEN_NM
from planetfall.systems.cover.chance import draws, patches
from planetfall.systems.cover.growth import Growing
from planetfall.systems.cover.near import plots_within
from planetfall.systems.cover.records import tree_records, windows
from planetfall.systems.cover.shadow_map import CoverMapBlock
from planetfall.systems.cover.stand import Species, plot_level
from planetfall.systems.terrain.height import TerrainField, TerrainParams
from planetfall.systems.terrain.height_table import octave_table
from planetfall.systems.terrain.material import TerrainMaterialBlock, material_block
from planetfall.systems.terrain.material_list import shaders

EARTH_M = 6.371e6
PLACE = (9.9122, 38.11012)


@pytest.fixture(scope="module")
def scene():
    with woods() as found:
        yield found


@pytest.fixture(scope="module")
def sampler(scene):
    return pf.CoverSampler(scene)


def direction(latitude_deg: float, longitude_deg: float) -> np.ndarray:
    a, b = np.deg2rad([latitude_deg, longitude_deg])
    return np.array([np.cos(a) * np.cos(b), np.cos(a) * np.sin(b), np.sin(a)])


def test_chance_is_uniform_and_independent():
    i, j = (c.ravel() for c in np.meshgrid(np.arange(200), np.arange(200), indexing="ij"))
    found = draws(5, 2, i, j, 3)
    assert found.min() >= 0.0 and found.max() < 1.0
    # Standard errors of 40 000 draws: 0.0014 of the mean, 0.005 of a correlation.
    assert abs(found.mean(axis=1) - 0.5).max() < 0.006
    beside = found[0].reshape(200, 200)
    pairs = [np.corrcoef(found)[0, 1], np.corrcoef(found)[1, 2]]
    pairs += [np.corrcoef(beside[:-1].ravel(), beside[1:].ravel())[0, 1]]
    assert max(abs(p) for p in pairs) < 0.02
    assert not np.array_equal(found, draws(6, 2, i, j, 3)) and not np.array_equal(found, draws(5, 3, i, j, 3))


def test_patches_are_smooth_across_their_cells():
    x = np.array([3.0 - 1e-9, 3.0 + 1e-9])
    near = patches(7, np.zeros(2, np.int64), x, np.full(2, 1.4))
    assert abs(near[1] - near[0]) < 1e-8


def test_plots_hold_the_circle():
    level, middle = plot_level(EARTH_M), direction(9.9, 38.1)
    plots = plots_within(middle, 500.0 / EARTH_M, level)
    area = np.pi * (500.0 / float(cell_edge_m(level, EARTH_M))) ** 2
    assert area < len(plots) < 2.2 * area and len(set(plots)) == len(plots)


@pytest.mark.parametrize("radius_m", [1e3, 5e4, 6.371e6, 7e7])
@pytest.mark.parametrize("middle", [(0.0, 0.0), (90.0, 0.0), (35.2644, 45.0), (-45.0, 44.99)], ids=str)
def test_no_plot_of_a_circle_is_missing(radius_m, middle):
    """From an asteroid to a giant, at a face's middle, a pole, a corner and an edge of the cube."""
    place, level, reach_m = direction(*middle), plot_level(radius_m), 700.0
    held = {(p.face, p.i, p.j) for p in plots_within(place, reach_m / radius_m, level)}
    rng = np.random.default_rng(3)
    x = np.cross(place, [0.3, 0.9, -0.2])
    x /= np.linalg.norm(x)
    turn, away = rng.uniform(0.0, 2.0 * np.pi, 4000), reach_m / radius_m * np.sqrt(rng.uniform(0.0, 1.0, 4000))
    aside = np.cos(turn)[:, None] * x + np.sin(turn)[:, None] * np.cross(place, x)
    asked = np.cos(away)[:, None] * place + np.sin(away)[:, None] * aside
    assert set(zip(*(c.tolist() for c in cell_of(asked, level)), strict=True)) <= held


def test_the_same_trees_from_anywhere(sampler):
    """A tree is what it is, whichever circle it was asked for in."""
    one = sampler.within(direction(*PLACE), 250.0)
    two = sampler.within(direction(PLACE[0] + 0.001, PLACE[1]), 250.0)
    names = {tuple(name): k for k, name in enumerate(one.names.tolist())}
    both = [(names[tuple(name)], k) for k, name in enumerate(two.names.tolist()) if tuple(name) in names]
    assert len(one) > 300 and len(names) == len(one) and len(both) > 100
    first, second = np.array(both).T
    # Heights of the ground depend on the batch in their last bits.
    np.testing.assert_allclose(one.positions_m[first], two.positions_m[second], rtol=0.0, atol=1e-6)
    np.testing.assert_array_equal(one.heights_m[first], two.heights_m[second])
    np.testing.assert_array_equal(one.species[first], two.species[second])


def test_they_stand_on_dry_and_gentle_ground(scene, sampler):
    found = sampler.within(direction(*PLACE), 400.0)
    ground = pf.TerrainSampler(scene)
    height = ground.height(found.positions_m)
    foot = np.linalg.norm(found.positions_m, axis=1) - EARTH_M
    np.testing.assert_allclose(foot, height - 0.1, atol=1e-6)
    assert height.min() > scene.planet[pf.Ocean].sea_level_m
    shrub = found.species == Species.SHRUB
    trees, shrubs = found.only(~shrub), found.only(shrub)
    assert ((trees.heights_m > 1.0) & (trees.heights_m < 25.0)).all()
    assert (trees.radii_m < np.where(trees.species == Species.ACACIA, 0.6, 0.5) * trees.heights_m).all()
    most_m = 1.2 * scene.planet[pf.Cover].shrub_height_m
    assert ((shrubs.heights_m > 0.3) & (shrubs.heights_m < most_m)).all() and len(shrubs) > 100


def test_none_stands_in_the_sea(scene, sampler):
    view = pf.view("sea", scene.planet)
    assert len(sampler.within(view.camera.resolve(scene).position_m, 300.0)) == 0


def test_they_stand_in_no_rows(sampler):
    """No peak of the spectrum of their density above three times its neighbours', beside that of the squares that they
    are drawn in: those are jittered over 0.8 of their width, which leaves a twentieth of the peak."""
    place = direction(*PLACE)
    found = sampler.within(place, 300.0)
    x = np.cross([0.0, 0.0, 1.0], place)
    x /= np.linalg.norm(x)
    flat = np.stack([found.positions_m @ x, found.positions_m @ np.cross(place, x)], axis=1)
    side = 128
    inside = (np.abs(flat) < 200.0).all(axis=1)
    density = np.histogram2d(*flat[inside].T, bins=side, range=[[-200.0, 200.0]] * 2)[0]
    power = (
        np.abs(np.fft.fft2((density - density.mean()) * np.hanning(side)[:, None] * np.hanning(side)))[:64, :64] ** 2
    )
    rows, columns = np.indices(power.shape)
    ring = np.hypot(rows, columns).astype(int)
    smooth = np.array([power[ring == r].mean() for r in range(64)])
    # Of exponentially distributed powers the largest of 3000 is eight times the mean.
    beyond = ring[(ring > 20) & (ring < 64)]
    peaks = (power[(ring > 20) & (ring < 64)] / smooth[beyond]).max()
    assert peaks < 14.0


def test_density_and_height_are_knobs(scene):
    place, cover = direction(*PLACE), scene.planet[pf.Cover]
    cover.shrubs = 0.0
    full = pf.CoverSampler(scene).within(place, 200.0)
    try:
        cover.density, cover.height_m = 0.5, 30.0
        half = pf.CoverSampler(scene).within(place, 200.0)
        cover.density = 0.0
        none = pf.CoverSampler(scene).within(place, 200.0)
        cover.shrubs = 1.0
        bushes = pf.CoverSampler(scene).within(place, 200.0)
        cover.shrubs = 0.5
        few = pf.CoverSampler(scene).within(place, 200.0)
    finally:
        cover.density, cover.height_m, cover.shrubs = 1.0, 15.0, 1.0
    assert 0.35 * len(bushes) < len(few) < 0.65 * len(bushes) and (bushes.species == Species.SHRUB).all()
    assert 0.35 * len(full) < len(half) < 0.65 * len(full) and len(none) == 0
    assert half.heights_m.mean() == pytest.approx(2.0 * full.heights_m.mean(), rel=0.1)


@pytest.mark.parametrize("radius_m", [0.0, -3.0, float("nan"), 1e6])
def test_a_bad_radius_is_refused(sampler, radius_m):
    with pytest.raises(ValueError, match="radius_m: expected metres above 0"):
        sampler.within(direction(*PLACE), radius_m)


def test_an_unknown_planet_is_refused(scene):
    with pytest.raises(ValueError, match=r"one of scene\.planets, found 'venus'"):
        pf.CoverSampler(scene, "venus")


def test_a_sampler_is_a_snapshot(scene):
    found = pf.CoverSampler(scene)
    cover = scene.planet[pf.Cover]
    try:
        cover.density = 0.0
        assert len(found.within(direction(*PLACE), 50.0)) > 5
    finally:
        cover.density = 1.0


def test_without_cover_a_sampler_says_what_to_do():
    with pf.load_scene("mars") as scene, pytest.raises(ValueError, match=r"scene\.planet\.add\(pf\.Cover\(\)\)"):
        pf.CoverSampler(scene)


# -- pictures --------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def renderer(scene):
    overrides = {"cover.reach_m": 150.0, "composite.antialiasing": "none"}
    with pf.Renderer(scene, size=(160, 90), quality="low", overrides=overrides) as found:
        yield found


def test_trees_are_drawn_where_the_sampler_says(scene, sampler, renderer):
    """Just above the foot of each tree in the picture that nothing hides there is a trunk, within a pixel."""
    view = pf.view("meadow", scene.planet)
    out = renderer.render(view, outputs=("surface", "position"))
    camera = renderer.camera_state(view)
    trees = sampler.within(camera.position_m, 60.0)
    up = camera.position_m / np.linalg.norm(camera.position_m)
    offset = trees.positions_m + 0.2 * trees.heights_m[:, None] * up - camera.position_m
    away = np.linalg.norm(offset, axis=1)
    x, y, z = offset @ camera.right, offset @ camera.up, offset @ camera.forward
    height, width = out["surface"].shape
    column = (x / z - camera.tan_left) / (camera.tan_right - camera.tan_left) * width
    row = (camera.tan_top - y / z) / (camera.tan_top - camera.tan_bottom) * height
    inside = (
        (z > 1.0) & (column > 2) & (column < width - 3) & (row > 2) & (row < height - 3) & (away > 8.0) & (away < 40.0)
    )
    seen = 0
    for k in np.flatnonzero(inside):
        i, j = int(row[k]), int(column[k])
        part = out["surface"][i - 1 : i + 2, j - 1 : j + 2]
        nearer = np.linalg.norm(out["position"][i - 1 : i + 2, j - 1 : j + 2], axis=-1) < away[k] - 2.0
        assert (part == Surface.COVER).any() or nearer.any(), (k, away[k])
        seen += bool((part == Surface.COVER).any())
    assert seen >= 3


def beside(scene, sampler, away_m: float, pitch_deg: float) -> pf.Camera:
    """A walker's eyes, so far from the trunk of a tree of view forest, and turned to it."""
    eye = pf.view("forest", scene.planet).camera.resolve(scene).position_m
    trees = sampler.within(eye, 60.0)
    foot = trees.positions_m[np.linalg.norm(trees.positions_m - eye, axis=1).argmin()]
    up = foot / np.linalg.norm(foot)
    east = np.cross((0.0, 0.0, 1.0), up)
    east /= np.linalg.norm(east)
    latitude, longitude = (float(v) for v in pf.latitude_longitude(foot + away_m * east))
    return pf.Camera.at(latitude, longitude, 1.7, above="ground", heading_deg=-90.0, pitch_deg=pitch_deg)


@pytest.mark.parametrize(("away_m", "pitch_deg"), [(1.5, 0.0), (1.5, 30.0), (4.0, 0.0), (9.0, 0.0)])
def test_a_walker_comes_up_to_a_trunk(scene, sampler, renderer, away_m, pitch_deg):
    camera = beside(scene, sampler, away_m, pitch_deg)
    renderer.settle(camera)
    out = renderer.render(camera, outputs=("surface", "distance"))
    height, width = out["surface"].shape
    middle = out["surface"][height // 2 - 2 : height // 2 + 3, width // 2 - 1 : width // 2 + 2]
    assert (middle == Surface.COVER).all()
    if pitch_deg == 0.0:
        assert out["distance"][height // 2, width // 2] == pytest.approx(away_m, rel=0.3)


def test_from_under_a_crown_leaves_are_overhead(scene, sampler, renderer):
    camera = beside(scene, sampler, 1.5, 70.0)
    renderer.settle(camera)
    assert (renderer.render(camera, outputs=("surface",))["surface"] == Surface.COVER).mean() > 0.3


def test_windows_hold_their_trees(scene, sampler):
    """Points of crowns and stems, from eyes under them, beside them and above."""
    eye = pf.view("forest", scene.planet).camera.resolve(scene).position_m
    plants = sampler.within(eye, 40.0)
    random = np.random.default_rng(5)
    for _ in range(20):
        k = random.integers(len(plants))
        foot = plants.positions_m[k]
        up = foot / np.linalg.norm(foot)
        camera = dataclasses.replace(
            pf.Camera.at(0.0, 0.0, 10.0, heading_deg=random.uniform(0, 360), pitch_deg=random.uniform(-60, 60)).resolve(
                scene
            ),
            position_m=foot + random.normal(size=3) * plants.heights_m[k],
        )
        tree = tree_records(plants.only(np.array([k])), camera.position_m)
        crown, stem = (window[0] for window in windows(tree, up[None], camera))
        turn, share = random.uniform(0, 2 * np.pi, 500), random.uniform(0.05, 1.0, 500)
        # The lowest of a broadleaf's lobes, cover/lobes.glsl.
        height, over_wide = float(tree["height_m"][0]), float(tree["radius_m"][0] / tree["height_m"][0])
        leaves = share > (0.05 if plants.species[k] == Species.CONIFER else 0.41 - 0.40 * over_wide)
        wide = np.where(leaves, plants.radii_m[k], 0.02 * height)
        east = np.cross(up, camera.forward)
        east /= np.linalg.norm(east)
        north = np.cross(up, east)
        points = tree["foot_m"][0] + (share * height)[:, None] * up
        points = points + wide[:, None] * (np.cos(turn)[:, None] * east + np.sin(turn)[:, None] * north)
        z = points @ camera.forward
        x = (points @ camera.right / z - camera.tan_left) / (camera.tan_right - camera.tan_left) * 2.0 - 1.0
        y = (points @ camera.up / z - camera.tan_bottom) / (camera.tan_top - camera.tan_bottom) * 2.0 - 1.0
        shown = (z > 0.1) & (abs(x) < 1.0) & (abs(y) < 1.0)
        x0, y0, x1, y1 = np.where(leaves[:, None], crown, stem).T
        assert ((x >= x0) & (x <= x1) & (y >= y0) & (y <= y1))[shown].all()


def test_they_shade_the_ground(scene, renderer):
    view = pf.view("meadow", scene.planet)
    renderer.settle(view)
    on = renderer.render(view, outputs=("radiance", "surface"))
    with pf.Renderer(
        scene, size=(160, 90), quality="low",
        overrides={"cover.reach_m": 150.0, "cover.shadows": False, "composite.antialiasing": "none"},
    ) as other:  # fmt: skip
        other.settle(view)
        off = other.render(view, outputs=("radiance", "surface"))
    ground = (on["surface"] == Surface.TERRAIN) & (off["surface"] == Surface.TERRAIN)
    ratio = on["radiance"][ground].sum(axis=-1) / off["radiance"][ground].sum(axis=-1)
    assert ratio.max() < 1.001 and 0.02 < (ratio < 0.7).mean() < 0.9


def test_they_shade_the_sea(scene):
    camera = pf.view("grove", scene.planet).camera
    latitude, longitude = (float(v) for v in pf.latitude_longitude(camera.resolve(scene).position_m))
    sun = pf.Sun(elevation_deg=30.0, azimuth_deg=180.0, latitude_deg=latitude, longitude_deg=longitude)
    shown = []
    for shadows in (True, False):
        overrides = {"cover.shadows": shadows, "composite.antialiasing": "none"}
        with pf.Renderer(scene, (160, 90), "low", overrides=overrides) as renderer:
            renderer.settle(camera)
            for _ in range(2):  # their map follows the sun by a frame
                out = renderer.render(camera, sun=sun, outputs=("radiance", "surface"))
            shown.append({name: value.copy() for name, value in out.items()})
    sea = (shown[0]["surface"] == Surface.SEA) & (shown[1]["surface"] == Surface.SEA)
    ratio = (shown[0]["radiance"].sum(axis=-1) / shown[1]["radiance"].sum(axis=-1))[sea]
    # What is mirrored stays, and so does the light of the sky.
    assert ratio.max() < 1.05 and 0.1 < (ratio < 0.85).mean() < 0.95


def test_still_water_mirrors_them():
    shown = []
    with pf.load_scene("woods") as scene:
        scene.planet.remove(pf.Clouds)
        view = pf.view("lakeside", scene.planet)
        for steps in (16, 0):
            overrides = {"ocean.reflections": steps, "composite.antialiasing": "none"}
            with pf.Renderer(scene, (160, 90), "medium", overrides) as renderer:
                renderer.settle(view)
                out = renderer.render(view, outputs=("radiance", "surface"))
                shown.append({name: value.copy() for name, value in out.items()})
    trees, water = shown[0]["surface"] == Surface.COVER, shown[0]["surface"] == Surface.SEA
    # Columns with many trees, and as far below the bank as these are high.
    many = np.flatnonzero(trees.sum(axis=0) > 5)
    assert len(many) > 30
    ratios = []
    for x in many:
        bank, high = int(np.flatnonzero(water[:, x])[0]), int(trees[:, x].sum())
        below = slice(bank + 1, bank + high - 1)
        ratios.append(shown[0]["radiance"][below, x].sum() / shown[1]["radiance"][below, x].sum())
    # Of each column's light, up to the picture's edges: of the sky alone, trees are much darker.
    assert np.median(ratios) < 0.7 and np.mean(np.array(ratios) < 0.9) > 0.9
    far_below = water & (np.arange(90)[:, None] > 80)
    assert shown[0]["radiance"][far_below] == pytest.approx(shown[1]["radiance"][far_below], rel=1e-3)


def test_a_still_camera_makes_and_uploads_nothing(scene, renderer):
    view = pf.view("meadow", scene.planet)
    renderer.settle(view)
    renderer.render(view)
    before = renderer.gpu.work.uploads
    renderer.render(view)
    assert renderer.gpu.work.uploads == before and renderer.stats["trees"] > 20


def test_far_above_there_are_none(scene, renderer):
    for _ in range(2):  # a renderer's first frame makes each list once
        renderer.render(pf.view("space", scene.planet))
    assert renderer.stats["trees"] == 0
    names = {report.name for report in renderer.passes() if report.ran}
    assert not any(name.startswith("cover.") for name in names)


def test_without_the_component_nothing_is_there_and_pictures_are_as_before(scene):
    with pf.load_scene("woods") as other:
        other.planet[pf.Terrain].rivers = 0.0
        other.planet.remove(pf.Clouds)
        view = pf.view("near", other.planet)
        with pf.Renderer(other, size=(96, 54), quality="low") as renderer:
            with_trees = renderer.snapshot(view).array
            other.planet.remove(pf.Cover)
            without = renderer.snapshot(view).array
            assert "cover" not in renderer.gpu.counts()
            assert not any(report.name.startswith("cover.") for report in renderer.passes())
    with pf.load_scene("earth") as plain:
        plain.planet.remove(pf.Cover)
        plain.planet[pf.Terrain].rivers = 0.0
        if plain.planet.get(pf.Clouds) is not None:
            plain.planet.remove(pf.Clouds)
        with pf.Renderer(plain, size=(96, 54), quality="low") as renderer:
            np.testing.assert_array_equal(renderer.snapshot(pf.view("near", plain.planet)).array, without)
    assert np.abs(with_trees.astype(int) - without).mean() > 1.0


def test_woods_are_those_of_the_materials(run_compute, gpu):
    """growth.py against terrain/material.glsl without noise, anywhere on Earth: moisture, humidity, warmth, forests."""
    terrain, up, scope = pf.Terrain(), direction(20.0, 30.0), gpu.scope("test")
    params = TerrainParams()
    field, rng = TerrainField(params), np.random.default_rng(9)
    away = rng.normal(size=(600, 3))
    places = away / np.linalg.norm(away, axis=1, keepdims=True)
    offsets = (places - up) * params.radius_m
    places = up + offsets.astype(np.float32).astype(np.float64) / params.radius_m
    places /= np.linalg.norm(places, axis=1, keepdims=True)
    height = rng.uniform(0.0, 4000.0, len(places)).astype(np.float32)
    block = scope.uniform_block(TerrainMaterialBlock, MATERIAL_BLOCK, "terrain_material_block")
    block.write(material_block(terrain, params, up, GIVEN_NM))
    scope.uniform_block(PlanetBlock, PLANET_BLOCK, "planet").bind()  # what grows asks nothing of it
    for name, text in shaders().items():
        gpu.shaders.add_virtual(name, text)
    table = scope.buffer(octave_table(params, up).tobytes())

    def bind(_):
        table.bind_to_uniform_block(4)
        block.bind()

    out = run_compute(
        """vec3 zenith = normalize(d + terrain_table.up * terrain_table.radius_m);
        moisture = terrain_point(d, 1e-3).moisture;
        Ground ground = ground_at(GroundDetail(vec3(0.0), vec3(0.0), 0.0, 0.0, 0.0), zenith, h, vec3(0.0), 0.0,
            moisture, 1.0, 1.0);
        warmth = ground.mean_warmth;
        humidity = ground.mean_humidity;
        Material material;
        stand_on(material, ground, 1.0, 1.0, 1.0);
        woods = material.growth.trees;
        """,
        {"d": offsets.astype(np.float32), "h": height},
        {"moisture": "float", "warmth": "float", "humidity": "float", "woods": "float"},
        header='#include "terrain/height.glsl"\n#include "terrain/material.glsl"',
        setup=bind,
    )  # fmt: skip
    scope.release()
    growing = Growing.of(terrain, 0.0)
    climate = growing.climate(field, places, height.astype(np.float64))
    # Offsets across the whole planet are floats: a metre of places, and moisture changes over thousands of kilometres.
    np.testing.assert_allclose(out["moisture"], field.moisture(places), atol=2e-5)
    np.testing.assert_allclose(out["warmth"], climate.warmth, atol=2e-5)
    np.testing.assert_allclose(out["humidity"], climate.humidity, atol=4e-5)
    woods = growing.woods(climate)
    # The steepest ramps of the rule: 1 / 0.13 by warmth, 1 / 0.22 and 1 / 0.30 by humidity.
    np.testing.assert_allclose(out["woods"], woods, atol=2e-5 / 0.13 + 4e-5 / 0.22 + 4e-5 / 0.30)
    assert 0.1 < (woods > 0.5).mean() < 0.9


def test_beaches_stay_where_forests_are_a_colour():
    """Sand by its colour in the picture without trees: with them it is bright, and land behind it less red."""
    shown = {}
    for density in (0.0, 1.0):
        with pf.load_scene("earth") as other:
            if not density:
                other.planet.remove(pf.Cover)
            other.planet[pf.Terrain].rivers = 0.0
            if other.planet.get(pf.Clouds) is not None:
                other.planet.remove(pf.Clouds)
            with pf.Renderer(other, size=(480, 270), quality="low") as renderer:
                view = pf.view("coast", other.planet)
                shown[density] = renderer.snapshot(view).array.astype(float)
                surface = renderer.render(view, outputs=("surface",))["surface"]
    bare, wooded = shown[0.0], shown[1.0]
    land = surface == Surface.TERRAIN
    sand = land & (bare[..., 0] - bare[..., 2] > 45.0)
    assert sand.sum() > 100
    # They share pixels with the wood behind; a colour over the beach as well leaves 0.61.
    assert wooded[sand].mean() > 0.8 * bare[sand].mean()
    assert wooded[land & ~sand][:, 0].mean() < 0.95 * bare[land & ~sand][:, 0].mean()


@pytest.mark.gpu
def test_trees_and_props_stand_in_one_picture():
    scene = pf.load_scene("woods")
    view = pf.view("near", scene.planet)
    with pf.Renderer(scene, size=(96, 54), quality="low") as renderer:
        state = renderer.camera_state(view)
        scene.add(pf.Transform(tuple(state.position_m + 300.0 * state.forward)), pf.Shape("sphere", (30.0, 30.0, 30.0)))
        renderer.settle(view)
        surface = renderer.render(view, outputs=("surface",))["surface"]
    assert {1, 3, 4} <= set(np.unique(surface).tolist())


def test_shaders_made_for_trees_find_their_names_where_there_are_none():
    """While a planet's trees are taken off, those of its ground are expanded once more with the contract's default."""
    text = (Path(pf.__file__).parents[1] / "assets/shaders" / "common/cover_light.glsl").read_text()
    members = re.search(r"struct CoverMap \{(.*?)\};", text, re.S)
    assert members is not None
    found = set(re.findall(r"(\w+)(?:\[\d+\])?[,;]", members[1]))
    of_the_map = {"x", "y", "middle_m", "per_m", "per_depth_m"}
    assert found == set(CoverMapBlock.__annotations__) - of_the_map


@pytest.mark.gpu
def test_shaders_made_for_trees_compile_without():
    with pf.Renderer(pf.load_scene("woods"), size=(64, 36), quality="low") as renderer:
        renderer.render(pf.view("near"))
        renderer.gpu.shaders.withdraw("cover")
        assert "terrain/shade.comp" in renderer.reload_shaders()
        assert renderer.shader_errors == []
