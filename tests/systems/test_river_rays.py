"""Rays beside rivers: what they know of valleys is a true bound, and the lines that they leave out say nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from river_kit import with_rivers

from planetfall.query.terrain import TerrainSampler
from planetfall.systems.terrain import height_rays
from planetfall.systems.terrain.gully_waves import Wave, wave_values
from planetfall.systems.terrain.height import TerrainParams, height, height_and_gradient
from planetfall.systems.terrain.height_octaves import STEEPEST_BANK, model_of
from planetfall.systems.terrain.height_surface import carve
from planetfall.systems.terrain.ray_valleys import Cut, valley_rise
from planetfall.systems.terrain.rivers.form import HELD
from planetfall.systems.terrain.rivers.pairs import river_pairs
from planetfall.systems.terrain.rivers.steepness import steepness
from planetfall.systems.terrain.rivers.valleys import valleys

EARTH = TerrainParams(mountains=0.4, roughness=1.35, hills=0.2)
RADII = (6e5, 6.371e6, 7e7)
ROUNDED_M = 1e-7
"""Heights of kilometres, and places on a planet of up to 70000 km, in double precision."""


def sized(radius_m: float) -> TerrainParams:
    relief_m = min(9000.0, 0.1 * radius_m)
    return replace(EARTH, radius_m=radius_m, highest_m=relief_m, lowest_m=-relief_m)


@pytest.fixture(scope="module", params=RADII)
def ground(request):
    return with_rivers(sized(request.param))[0]


def beside(params, count, rng):
    """Points (N, 3) on the sphere, from a metre to 6 km (by the planet's scale) beside lines."""
    table = params.rivers
    line = rng.choice(np.flatnonzero(table.to >= 0), count)
    step_m = table.cell_m / 2.0**22
    a, b = table.place[line] * step_m, table.place[table.to[line]] * step_m
    place = a + rng.uniform(size=(count, 1)) * (b - a)
    away_m = np.exp(rng.uniform(0.0, np.log(6e3), count)) * params.scale
    place = place + level(place, rng) * away_m[:, None]
    return place * (params.radius_m / np.linalg.norm(place, axis=1))[:, None]


def level(place, rng):
    """A level unit vector (N, 3) at each place, in any direction."""
    up = place / np.linalg.norm(place, axis=1)[:, None]
    side = rng.normal(size=place.shape)
    side -= up * (side * up).sum(axis=1)[:, None]
    return side / np.linalg.norm(side, axis=1)[:, None]


def above_the_line(heights):
    """(N, M) of heights (N, M) over the straight line between first and last."""
    share = np.linspace(0.0, 1.0, heights.shape[1])
    return heights - heights[:, :1] - (heights[:, -1:] - heights[:, :1]) * share


def test_no_ground_rises_above_the_bound(ground):
    """Dense ground on thousands of stretches of all lengths. With a tenth of what valleys add the bound is none."""
    table, rng = ground.rivers, np.random.default_rng(21)
    plain = replace(ground, rivers=None)
    tight = 0
    for length_m in ground.scale * 2.0 ** np.arange(12.0, -8.0, -1.0):
        start = beside(ground, 400, rng)
        way = level(start, rng) * length_m
        places = start[:, None] + np.linspace(0.0, 1.0, 25)[:, None] * way[:, None]
        directions = (places / np.linalg.norm(places, axis=2)[..., None]).reshape(-1, 3)
        uncarved, carved = (height(directions, p).reshape(400, 25) for p in (plain, ground))
        ends = []
        for k in (0, -1):
            feet = np.ascontiguousarray(directions.reshape(400, 25, 3)[:, k].T) * ground.radius_m
            cut, own = valleys(table, feet), uncarved[:, k]
            moved = np.abs(own - carve(own, cut.base_m, cut.open, cut.raised))
            ends.append(Cut(own - cut.base_m, cut.base_m, cut.open, moved, steepness(cut, table)))
        rise = np.abs(above_the_line(uncarved)).max(axis=1)
        more = valley_rise(*ends, np.full(400, length_m), rise, table.steepest_per_m)
        risen = above_the_line(carved).max(axis=1)
        assert (risen <= rise + more + ROUNDED_M).all()
        tight += int((risen > rise + 0.1 * more + ROUNDED_M).sum())
    assert tight > 0


@pytest.mark.parametrize("erosion", [0.0, 1.0])
def test_hits_are_those_of_the_steepest_valleys(erosion, monkeypatch):
    """As with a bound that takes every valley and bank for the planet's steepest."""
    ground = replace(with_rivers(EARTH)[0], erosion=erosion)
    sampler, rng = TerrainSampler.from_params(ground), np.random.default_rng(22)
    start = beside(ground, 40, rng)
    up = start / np.linalg.norm(start, axis=1)[:, None]
    pitch = np.radians(rng.uniform(-4.0, 3.0, len(up)))[:, None]
    ways = level(start, rng) * np.cos(pitch) + up * np.sin(pitch)
    origins = up * (ground.radius_m + sampler.height(up) + 5.0)[:, None]
    hit, distance = sampler.raycast(origins, ways, 3000.0)

    def steepest(a, b, length_m, rise, steepest_per_m):
        high = np.maximum(np.abs(a.above_m), np.abs(b.above_m)) + rise
        slope = steepest_per_m * high + STEEPEST_BANK
        return np.minimum(np.maximum(a.cut_m, b.cut_m), 0.5 * length_m * slope)

    monkeypatch.setattr(height_rays, "valley_rise", steepest)
    other, expected = sampler.raycast(origins, ways, 3000.0)
    assert 0.3 < hit.mean() < 1.0 and (hit == other).all()
    np.testing.assert_allclose(distance[hit], expected[hit], atol=1e-6)


def test_lines_that_are_left_out_say_nothing(ground):
    points = np.ascontiguousarray(beside(ground, 2000, np.random.default_rng(23)).T)
    whole, some = river_pairs(ground.rivers, points, in_reach=False), river_pairs(ground.rivers, points)
    assert whole is not None and some is not None
    floor, reach = whole.value[3:5]
    kept = np.flatnonzero(whole.d < np.maximum(reach, floor + HELD * reach))
    assert len(kept) < 0.6 * len(whole.d)
    for name in ("where", "line", "d", "value", "steps", "away", "along", "end_m"):
        np.testing.assert_array_equal(getattr(some, name), getattr(whole, name)[..., kept])
    np.testing.assert_array_equal(some.where[some.first], some.near)
    np.testing.assert_array_equal(np.repeat(some.near, some.many), some.where)
    np.testing.assert_array_equal(some.bends.fraction, whole.bends.fraction[..., np.isin(whole.near, some.near)])


def test_cells_are_found_among_all(ground):
    table, rng = ground.rivers, np.random.default_rng(24)
    asked = np.concatenate(
        [rng.choice(table.keys, 500), rng.integers(0, 2**30, 500), table.keys[[0, -1]], [0, 2**30 - 1]]
    )
    near, cells = table.cells_at(asked)
    np.testing.assert_array_equal(near, np.flatnonzero(np.isin(asked, table.keys)))
    np.testing.assert_array_equal(table.keys[cells], asked[near])


def test_waves_are_the_same_with_and_without_derivatives():
    rng = np.random.default_rng(25)
    model = model_of(replace(EARTH, erosion=1.0))
    points = rng.normal(size=(3, 300)) * 1e6
    cells = model.unwarped.cells(points).part(slice(4, 5))
    along = rng.normal(size=(3, 300))
    along /= np.sqrt((along * along).sum(axis=0))
    real, imaginary = wave_values(cells, along)
    expected = Wave(cells, along).value
    assert np.abs(expected).max() > 0.9
    np.testing.assert_allclose(real + 1j * imaginary, expected, atol=1e-13)


@pytest.mark.parametrize("craters", [0.0, 0.5])
def test_heights_are_those_of_gradients(ground, craters):
    """Gullies are followed in two ways, with derivatives and without."""
    params = replace(ground, erosion=1.0, craters=craters)
    directions = beside(params, 1500, np.random.default_rng(26)) / params.radius_m
    np.testing.assert_allclose(height(directions, params), height_and_gradient(directions, params)[0], atol=1e-8)
