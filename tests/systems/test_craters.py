"""Craters: shapes against the published ones, gradients, counts, bounds, and the GPU's twin."""

from __future__ import annotations

import numpy as np
import pytest
from test_height_gpu import anchors, evaluate, offsets  # noqa: F401 - evaluate is a fixture

import planetfall as pf
from planetfall.systems.terrain.craters import AREA_SHARE, craters_of, fresh_shape
from planetfall.systems.terrain.height import (
    TerrainField,
    TerrainParams,
    height,
    height_and_gradient,
    height_at_points,
)
from planetfall.systems.terrain.height_table import octave_table

MOON_M = 1.7374e6
MOON = TerrainParams(
    MOON_M, 7, 8000.0, -7000.0, 16, 0.5, plains=0.3, mountains=0.5, craters=0.8, crater_largest_m=2.5e5
)
MARS = TerrainParams(3.3895e6, 4, 12000.0, -8000.0, 16, 0.6, mountains=0.6, craters=0.4, crater_largest_m=2e5)
ROCK = TerrainParams(1000.0, 11, 100.0, -100.0, 10, 0.5, plains=0.0, craters=1.0, crater_largest_m=700.0)
WORLDS = {"moon": MOON, "mars": MARS, "rock": ROCK}


def sphere(count, seed=0):
    d = np.random.default_rng(seed).normal(size=(count, 3))
    return d / np.linalg.norm(d, axis=1)[:, None]


@pytest.mark.parametrize("diameter_km", [1.0, 5.0, 14.0, 20.0, 60.0, 200.0])
def test_fresh_craters_have_pikes_depths_and_rims(diameter_km):
    """Pike 1977: of his laws for simple and for complex craters the lower one. Ours leave out the powers 0.010 and
    0.014 and 4 % of the depth, which round bottoms take."""
    wall, floor, rim, _ = fresh_shape(diameter_km * 1e3, MOON_M)
    depth_km = min(0.196 * diameter_km**1.010, 1.044 * diameter_km**0.301)
    rim_km = min(0.036 * diameter_km**1.014, 0.236 * diameter_km**0.399)
    assert floor * diameter_km / 2.0 == pytest.approx(depth_km, rel=0.08)
    assert rim * diameter_km / 2.0 == pytest.approx(rim_km, rel=0.08)
    assert wall >= floor


def test_density_one_covers_the_share_that_it_says():
    """Counted from places: inside a crater's rim the younger wipes out the older, so count what one octave covers."""
    craters = craters_of(1.0, 6.5e4, 6e4, MOON_M, 3)
    assert len(craters) == 1
    flat = fresh_shape(1e3, MOON_M)  # simple, so that all of the inside is below the surroundings
    object.__setattr__(craters, "shape", np.array([flat]))
    below = craters.heights(np.ascontiguousarray(sphere(40000).T) * MOON_M) < 0.0
    # A simple crater is below the level around it up to x^2 = 1 - rim / wall; worn crests are lower: a little further.
    share = below.mean() / AREA_SHARE
    assert 1.0 - flat[2] / flat[0] - 0.1 < share < 1.0


@pytest.mark.parametrize("world", WORLDS)
def test_gradients_are_the_slopes_of_the_heights(world):
    params = WORLDS[world]
    d = sphere(1500, 1)
    t = np.cross(d, np.roll(d, 1, axis=1) + 0.1)
    t /= np.linalg.norm(t, axis=1)[:, None]
    step = 1e-9 * params.radius_m if params.radius_m > 1e5 else 1e-5
    points = d * params.radius_m
    slope = (height_at_points(points + step * t, params) - height_at_points(points - step * t, params)) / (2.0 * step)
    _, gradient = height_and_gradient(d, params)
    # Rounding of heights of 10 km over such steps is 1e-9 / step; crests bend within their width.
    error = np.abs((gradient * t).sum(axis=1) - slope)
    assert np.quantile(error, 0.95) < 2e-4 and np.median(error) < 1e-5


@pytest.mark.parametrize("world", WORLDS)
def test_heights_are_continuous_everywhere(world):
    """Lattice cells end in the middle of the ground: a walk across many of them has no jump."""
    params = WORLDS[world]
    rng = np.random.default_rng(2)
    for octave_m in (2.0**-2, 1.0) if params.radius_m < 1e5 else (1.0, 30.0, 2000.0):
        a = sphere(1, int(rng.integers(1000)))[0]
        side = np.cross(a, [0.2, 0.3, 0.9])
        side /= np.linalg.norm(side)
        arc = np.arange(4000) * (octave_m * 0.01 / params.radius_m)
        h = height(np.cos(arc)[:, None] * a + np.sin(arc)[:, None] * side, params)
        assert np.abs(np.diff(h)).max() < 4.0 * octave_m * 0.01, "steeper than any crater's wall"


@pytest.mark.parametrize("world", WORLDS)
def test_bounds_hold_and_the_slope_bound_does_nearly_always(world):
    params = WORLDS[world]
    field, d = TerrainField(params), sphere(4000, 5)
    h, slope = field.height_slope(d)
    np.testing.assert_allclose(h, field.height(d), atol=1e-6)
    assert h.max() < params.highest_m and h.min() > params.lowest_m
    _, gradient = field.height_gradient(d)
    assert np.mean(np.linalg.norm(gradient, axis=1) > slope) < 1e-3


def test_none_cost_nothing():
    assert craters_of(0.0, 1e5, 1.0, MOON_M, 1) is None
    assert octave_table(TerrainParams(), np.array([0.0, 0.0, 1.0]))["crater_octaves"] == 0


def test_more_density_is_more_craters_at_the_same_places():
    rare, dense = (craters_of(k, 2.5e5, 1e3, MOON_M, 9) for k in (0.3, 0.9))
    points = np.ascontiguousarray(sphere(3000, 4).T) * MOON_M
    assert np.std(dense.heights(points)) > np.std(rare.heights(points)) > 0.0


@pytest.mark.parametrize("world", WORLDS)
def test_heights_on_the_gpu(evaluate, world):  # noqa: F811
    """1 mm within 1 km of the anchor, as for the noise; a millionth of the relief anywhere."""
    params, near, far = WORLDS[world], [], []
    reach = min(1000.0, params.radius_m)
    for i, up in enumerate(anchors(4)):
        base = height_at_points(up[None] * params.radius_m, params)[0]
        rng = np.random.default_rng(i)
        for distances, errors in (
            (reach * np.sqrt(rng.random(300)), near),
            (10.0 ** rng.uniform(np.log10(reach), np.log10(3.1 * params.radius_m), 300), far),
        ):
            d = offsets(up, params.radius_m, distances, i)
            expected = height_at_points(up * params.radius_m + d.astype(np.float64), params) - base
            errors.append(np.abs(evaluate(params, up, d, 1e-4)["dh"] - expected))
    assert np.max(near) <= 1e-3
    assert np.quantile(far, 0.99) <= 1e-6 * (params.highest_m - params.lowest_m)
    assert np.max(far) <= 1e-5 * (params.highest_m - params.lowest_m)


@pytest.mark.parametrize("spacing", [0.5, 30.0, 2000.0])
def test_band_limited_gradients_on_the_gpu(evaluate, spacing):  # noqa: F811
    up = anchors(1)[-1]
    d = offsets(up, MOON_M, np.linspace(1.0, 3e4, 300))
    points = up * MOON_M + d.astype(np.float64)
    _, gradient = height_and_gradient(points / np.linalg.norm(points, axis=1)[:, None], MOON, spacing)
    found = evaluate(MOON, up, d, spacing)["gradient"]
    error = np.linalg.norm(found - gradient, axis=1)
    assert np.quantile(error, 0.99) < 2e-3 and np.median(error) < 1e-4


@pytest.mark.parametrize("backend", ["grid", "quadtree", "icosphere"])
def test_every_backend_draws_craters_and_map(backend):
    """Below the camera, where the mesh is finest: the triangles within some steps of theirs of the sampler's ground."""
    with pf.load_scene("moon") as scene:
        scene.planet[pf.Terrain].backend = backend
        camera = pf.Camera.at(-25.85, 9.51, 3000.0, pitch_deg=-60.0, above="ground")
        around = np.random.default_rng(1).normal(size=(40, 3)) * 400.0 / MOON_M
        d = pf.direction(-25.85, 9.51) + around
        d /= np.linalg.norm(d, axis=1)[:, None]
        truth = pf.TerrainSampler(scene).height(d)
        fine = {"terrain.error_px": 0.5}  # the tiles' own bound; the grid's is finer here
        with pf.Renderer(scene, size=(96, 54), quality="high", overrides=fine) as renderer:
            renderer.settle(camera)
            renderer.render(camera)
            drawn = renderer.height_drawn(d)
    assert np.ptp(truth) > 400.0, "there is something to see"
    # From 3 km, 54 pixels for 60 degrees: a pixel is 64 m. Errors are measured at samples, twice the bound.
    assert np.isfinite(drawn).all() and np.abs(drawn - truth).max() < 64.0


def test_craters_come_and_go_while_running():
    """Shaders of the ground are compiled without what it has not: a change has to find its way into all of them."""
    camera = pf.Camera.at(10.0, 20.0, 30000.0, pitch_deg=-40.0)

    def picture(renderer):
        renderer.settle(camera)
        return np.nan_to_num(renderer.render(camera, outputs=("normal",))["normal"])

    with pf.load_scene("small") as scene, pf.Renderer(scene, size=(96, 54), quality="low") as renderer:
        bare = picture(renderer)
        scene.planet[pf.Terrain].craters = 1.0
        cratered = picture(renderer)
        with pf.Renderer(scene, size=(96, 54), quality="low") as fresh:
            # Normals are kept in steps of 3e-5, and anchors differ by what the proxies had been through.
            np.testing.assert_allclose(picture(fresh), cratered, atol=1e-4)
        scene.planet[pf.Terrain].craters = 0.0
        np.testing.assert_allclose(picture(renderer), bare, atol=1e-4)
    assert np.abs(cratered - bare).max() > 0.1, "a wall somewhere"
