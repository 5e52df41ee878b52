"""Gullies below the samples of tiles: they follow the slope of the samples. The GPU: test_real_ground_gpu.py."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from countries import write_hgt

from planetfall.engine.real_ground.lattice import directions_at
from planetfall.engine.real_ground.resident import real_ground
from planetfall.systems.terrain.height import (
    TerrainField,
    TerrainParams,
    height,
    height_and_gradient,
    height_at_points,
)

RADIUS_M = 6.371e6
PLAIN = TerrainParams(mountains=0.4, roughness=1.35, hills=0.2)


@pytest.fixture(scope="module")
def steep(tmp_path_factory):
    """A plane that falls to the south by 0.5, with samples rough by 20 m."""
    side = 301
    rows = np.mgrid[:side, :side][0] * 370.6
    rough = np.random.default_rng(2).normal(0.0, 15.0, (side, side))
    folder = tmp_path_factory.mktemp("steep")
    write_hgt(folder, 46, 7, side, np.rint(np.clip(9000.0 - 0.25 * rows, 200.0, None) + rough).astype(np.int16))
    return replace(PLAIN, real=real_ground(str(folder), 64_000_000, "x"), erosion=1.0, highest_m=12e3)


def within(count, south=46.75, north=46.95, seed=1):
    rng = np.random.default_rng(seed)
    return directions_at(rng.uniform(south, north, count), rng.uniform(7.2, 7.8, count)).T


def slope_along(params, at, step_m):
    side = np.cross(at, [0.3, 0.2, 1.0])
    side /= np.linalg.norm(side, axis=1)[:, None]
    ends = [at + sign * side * (step_m / RADIUS_M) for sign in (1.0, -1.0)]
    high, low = (height(e / np.linalg.norm(e, axis=1)[:, None], params) for e in ends)
    return side, (high - low) / (2.0 * step_m)


def test_without_detail_heights_are_the_files(steep):
    """To the bit as without erosion; so is level ground."""
    bare, at = replace(steep, height_map_detail=0.0), within(500)
    np.testing.assert_array_equal(height(at, bare), height(at, replace(bare, erosion=0.0)))
    assert np.abs(height(at, steep) - height(at, bare)).max() > 1.0


def test_level_tiles_have_none(tmp_path):
    samples = np.rint(np.random.default_rng(3).normal(500.0, 2.0, (121, 121)))  # 930 m apart: slopes of 0.3 %
    write_hgt(tmp_path, 46, 7, 121, samples.astype(np.int16))
    params = replace(PLAIN, real=real_ground(str(tmp_path), 64_000_000, "x"), erosion=1.0)
    at = within(2000, 46.1, 46.9)
    np.testing.assert_array_equal(height(at, params), height(at, replace(params, erosion=0.0)))


def test_the_gradient_is_that_of_the_heights(steep):
    at = within(1500)
    found_m, gradient = height_and_gradient(at, steep)
    np.testing.assert_allclose(found_m, height(at, steep), atol=1e-9)
    side, found = slope_along(steep, at, 0.05)
    error = np.abs(found - (gradient * side).sum(axis=1))
    assert np.percentile(error, 90) < 0.01
    assert np.percentile(error, 99) < 0.05


def test_furrows_run_down_the_slope(steep):
    """Along the contour ground bends more than down the slope; without gullies alike."""
    at = within(3000)
    _, gradient = height_and_gradient(at, replace(steep, height_map_detail=0.0))
    down = gradient / np.linalg.norm(gradient, axis=1)[:, None]
    across = np.cross(at, down)

    def bends(params, way, step_m=30.0):
        ends = (at + k * way * (step_m / RADIUS_M) for k in (1.0, 0.0, -1.0))
        high, middle, low = (height(e / np.linalg.norm(e, axis=1)[:, None], params) for e in ends)
        return float(np.sqrt(((high - 2.0 * middle + low) ** 2).mean()))

    before, after = (bends(p, across) / bends(p, down) for p in (replace(steep, erosion=0.0), steep))
    assert 0.9 < before < 1.1
    assert after > 1.5 * before


def test_slopes_are_bounded(steep):
    at = within(4000)
    _, gradient = height_and_gradient(at, steep)
    _, bound = TerrainField(steep).height_slope(at)
    assert (np.linalg.norm(gradient, axis=1) > bound).mean() < 2e-3


@pytest.mark.parametrize("longitude_deg", [7.0, 8.0])
def test_heights_are_continuous_across_the_border(steep, longitude_deg):
    """Steps of 1 cm over the margin, in which tiles pass into the ground around."""
    along = longitude_deg + np.linspace(-0.05, 0.05, 40)[:, None]
    steps = np.arange(50) * (0.01 / 6.371e6)
    starts = directions_at(np.full(40, 46.8), along[:, 0]).T
    east = np.cross([0.0, 0.0, 1.0], starts)
    east /= np.linalg.norm(east, axis=1)[:, None]
    at = starts[:, None] + steps[None, :, None] * east[:, None]
    h = height_at_points(at.reshape(-1, 3) * (RADIUS_M / np.linalg.norm(at.reshape(-1, 3), axis=1)[:, None]), steep)
    assert np.abs(np.diff(h.reshape(40, 50), axis=1)).max() < 0.01 * 3.0


def test_many_places_are_each_as_alone(steep):
    at = within(300)
    one_by_one = np.array([height(d[None], steep)[0] for d in at[:40]])
    np.testing.assert_allclose(height(at, steep)[:40], one_by_one, atol=1e-9)
