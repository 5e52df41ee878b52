"""Gullies: relief that follows the slope. Gradients against heights, the GPU against float64, what they look like."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from river_kit import with_rivers

from planetfall.engine.blocks.bindings import RIVERS_UNIT
from planetfall.systems.terrain.height import TerrainField, TerrainParams, height, height_and_gradient, height_at_points
from planetfall.systems.terrain.height_table import canonical_table, octave_table
from planetfall.systems.terrain.rivers.texture import river_texels

PLAIN = TerrainParams(mountains=0.4, roughness=1.35, hills=0.2)
EARTH = replace(PLAIN, erosion=1.0)
RADII = (1e3, 6e5, 3.4e6, 6.371e6, 7e7)


def sized(radius_m: float, seed: int = 1) -> TerrainParams:
    relief_m = min(9000.0, 0.1 * radius_m)
    return replace(EARTH, radius_m=radius_m, seed=seed, highest_m=relief_m, lowest_m=-relief_m)


def steep_ground(params, count, seed=1):
    """Unit directions (N, 3) to the steepest tenth of some ground."""
    d = np.random.default_rng(seed).normal(size=(10 * count, 3))
    d /= np.linalg.norm(d, axis=1)[:, None]
    plain = replace(params, erosion=0.0, rivers=None)
    _, gradient = height_and_gradient(d, plain, 3000.0 * params.scale)
    return d[np.argsort(-np.linalg.norm(gradient, axis=1))[:count]]


def slope_along(params, at, step_m):
    side = np.cross(at, [0.3, 0.2, 1.0])
    side /= np.linalg.norm(side, axis=1)[:, None]
    ends = [at + sign * side * (step_m / params.radius_m) for sign in (1.0, -1.0)]
    high, low = (height(e / np.linalg.norm(e, axis=1)[:, None], params) for e in ends)
    return side, (high - low) / (2.0 * step_m)


@pytest.mark.parametrize("radius_m", RADII)
def test_the_gradient_is_that_of_the_heights(radius_m):
    """Within half a degree in nine of ten places of the steepest: what is left out is said in gullies.py."""
    params = sized(radius_m)
    at = steep_ground(params, 800)
    _, gradient = height_and_gradient(at, params)
    side, found = slope_along(params, at, 0.05 * min(params.scale, 1.0))
    error = np.abs(found - (gradient * side).sum(axis=1))
    assert np.percentile(error, 90) < 0.01
    assert np.percentile(error, 99) < 0.05
    assert np.percentile(np.linalg.norm(gradient, axis=1), 75) > 0.1


def test_beside_rivers_too():
    params, nodes = with_rivers(EARTH)
    rng = np.random.default_rng(3)
    at = nodes.direction[rng.integers(len(nodes.direction), size=1000)] + rng.normal(size=(1000, 3)) * 6e-4
    at /= np.linalg.norm(at, axis=1)[:, None]
    _, gradient = height_and_gradient(at, params)
    side, found = slope_along(params, at, 0.05)
    assert np.percentile(np.abs(found - (gradient * side).sum(axis=1)), 90) < 0.04
    np.testing.assert_allclose(height_and_gradient(at, params)[0], height(at, params), atol=1e-9)


def test_slopes_are_bounded():
    at = steep_ground(EARTH, 3000)
    _, gradient = height_and_gradient(at, EARTH)
    _, bound = TerrainField(EARTH).height_slope(at)
    assert (np.linalg.norm(gradient, axis=1) > bound).mean() < 2e-3


def test_gentle_ground_is_as_it_was():
    """Where nothing is steep there are no gullies; the sea's level and the broad shape stay."""
    d = np.random.default_rng(5).normal(size=(20000, 3))
    d /= np.linalg.norm(d, axis=1)[:, None]
    before, after = height(d, PLAIN), height(d, EARTH)
    assert (before == after).mean() > 0.2
    assert np.abs(after - before).max() < 400.0
    assert abs((after > 0.0).mean() - (before > 0.0).mean()) < 2e-3


def test_furrows_run_down_the_slope():
    """Along the contour ground bends more than down the slope: a fifth more at 60 m; without gullies alike."""
    at = steep_ground(PLAIN, 1500)
    _, gradient = height_and_gradient(at, PLAIN, 2000.0)
    down = gradient / np.linalg.norm(gradient, axis=1)[:, None]
    across = np.cross(at, down)

    def bends(params, way, step_m=60.0):
        high, middle, low = (height(_unit(at + k * way * (step_m / params.radius_m)), params) for k in (1.0, 0.0, -1.0))
        return float(np.sqrt(((high - 2.0 * middle + low) ** 2).mean()))

    before, after = (bends(p, across) / bends(p, down) for p in (PLAIN, EARTH))
    assert 0.9 < before < 1.1
    assert after > 1.2 * before


def _unit(v):
    return v / np.linalg.norm(v, axis=1)[:, None]


# -- the GPU -----------------------------------------------------------------------------------------------------------

CHOSEN = "#define TERRAIN_SOURCES_CHOSEN\n#define TERRAIN_ERODED\n"
BODY = "TerrainPoint p = terrain_point(d, spacing); dh = p.dh; gradient = p.gradient;"
OUTPUTS = {"dh": "float", "gradient": "vec3"}


def offsets(up, radius_m, distances_m, seed):
    side = np.cross(up, [0.3, 0.5, 0.8])
    side /= np.linalg.norm(side)
    azimuth = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, len(distances_m))[:, None]
    angle = (distances_m / radius_m)[:, None]
    across = np.cos(azimuth) * side + np.sin(azimuth) * np.cross(up, side)
    return (radius_m * (np.sin(angle) * across - 2.0 * np.sin(0.5 * angle) ** 2 * up)).astype(np.float32)


@pytest.fixture
def evaluate(run_compute, gpu):
    """evaluate(params, table, body, header, inputs, outputs)"""
    scope = gpu.scope("test")

    def run(params, table, body, header, inputs, outputs):
        block = scope.buffer(table.tobytes())
        texture = None
        if params.rivers is not None:
            _, texels = river_texels(params.rivers)
            texture = scope.texture(texels.shape[1::-1], "rgba32ui", texels.view(np.uint32))

        def bind(_):
            block.bind_to_uniform_block(4)
            if texture is not None:
                texture.use(RIVERS_UNIT)

        chosen = CHOSEN + ("#define TERRAIN_RIVERS\n#define TERRAIN_CARVED\n" if texture is not None else "")
        return run_compute(body, inputs, outputs, header=f"{chosen}#include {header}", setup=bind)

    yield run
    scope.release()


@pytest.mark.parametrize("radius_m", RADII)
def test_heights_around_an_anchor(evaluate, radius_m):
    """A millimetre within a kilometre, a millionth of the distance beyond; gradients to 1e-3."""
    params = sized(radius_m)
    for k, up in enumerate(steep_ground(params, 4, seed=7)):
        rng = np.random.default_rng(k)
        near = min(1000.0, 0.02 * radius_m) * np.sqrt(rng.random(400))
        distances = np.concatenate([near, 10.0 ** rng.uniform(0.0, np.log10(0.02 * radius_m), 400)])
        d = offsets(up, radius_m, distances, k)
        points = up * radius_m + d.astype(np.float64)
        base = height_at_points(up[None] * radius_m, params)[0]
        inputs = {"d": d, "spacing": np.float32(1e-3)}
        found = evaluate(params, octave_table(params, up), BODY, '"terrain/height.glsl"', inputs, OUTPUTS)
        error = np.abs(found["dh"] - (height_at_points(points, params) - base))
        assert (error / (1e-6 * np.maximum(distances, 1000.0))).max() <= 1.0
        _, gradient = height_and_gradient(points / radius_m, params, 1e-3)
        assert np.percentile(np.linalg.norm(found["gradient"] - gradient, axis=1), 99) < 1e-3


@pytest.mark.parametrize("spacing_m", [20.0, 150.0, 2000.0])
def test_gradients_of_wide_spacings(evaluate, spacing_m):
    """Band-limited as float64's are."""
    up = steep_ground(EARTH, 3, seed=9)[1]
    d = offsets(up, EARTH.radius_m, 10.0 ** np.random.default_rng(2).uniform(1.0, 4.0, 500), 2)
    inputs = {"d": d, "spacing": np.float32(spacing_m)}
    found = evaluate(EARTH, octave_table(EARTH, up), BODY, '"terrain/height.glsl"', inputs, OUTPUTS)
    points = up * EARTH.radius_m + d.astype(np.float64)
    _, gradient = height_and_gradient(points / EARTH.radius_m, EARTH, spacing_m)
    assert np.percentile(np.linalg.norm(found["gradient"] - gradient, axis=1), 99) < 1e-3


def test_heights_in_float(evaluate):
    """A tenth of a metre, as without gullies; on steep ground beside rivers, too."""
    params, nodes = with_rivers(EARTH)
    for k, up in enumerate([*steep_ground(EARTH, 2, seed=3), nodes.direction[5]]):
        d = offsets(up, params.radius_m, 10.0 ** np.random.default_rng(k).uniform(3.0, 6.0, 600), k)
        found = evaluate(
            params, octave_table(params, up), "h = terrain_far_height(d, 1e-3);", '"terrain/far_height.glsl"', {"d": d},
            {"h": "float"},
        )  # fmt: skip
        assert np.abs(found["h"] - height_at_points(up * params.radius_m + d.astype(np.float64), params)).max() <= 0.1


@pytest.mark.parametrize("radius_m", RADII)
def test_canonical_heights(evaluate, radius_m):
    """Of one direction alone, to a millimetre."""
    params = sized(radius_m)
    at = steep_ground(params, 3000)
    high = at.astype(np.float32)
    found = evaluate(
        params, canonical_table(params), "Pair h; terrain_canonical(Pair3(a, b), 1e-3, h); x = h.high; y = h.low;",
        '"terrain/canonical_height.glsl"', {"a": high, "b": (at - high).astype(np.float32)},
        {"x": "float", "y": "float"},
    )  # fmt: skip
    assert np.abs(found["x"].astype(np.float64) + found["y"] - height(at, params)).max() <= 1e-3
