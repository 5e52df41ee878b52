"""Uneven banks: where noise moves the edges of rivers and lakes, and what that leaves alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from river_kit import with_rivers

import planetfall as pf
from planetfall.systems.terrain.height import TerrainParams, height, height_and_gradient
from planetfall.systems.terrain.rivers.banks import bank_bits
from planetfall.systems.terrain.rivers.form import BANK_FAR, BANK_NARROWEST
from planetfall.systems.terrain.rivers.pairs import river_pairs
from planetfall.systems.terrain.rivers.table import CELL_STEPS, RiverTable
from planetfall.systems.terrain.rivers.valleys import waters

Floats = NDArray[np.float64]
EARTH = TerrainParams(mountains=0.4, roughness=1.35, hills=0.2)
RADII = (1e3, 6e5, 6.371e6, 7e7)


def sized(radius_m: float) -> TerrainParams:
    relief_m = min(9000.0, 0.1 * radius_m)
    return replace(EARTH, radius_m=radius_m, highest_m=relief_m, lowest_m=-relief_m)


@pytest.fixture(scope="module", params=RADII)
def ground(request: pytest.FixtureRequest) -> TerrainParams:
    return with_rivers(sized(request.param))[0]


def straight(params: TerrainParams) -> TerrainParams:
    assert params.rivers is not None
    return replace(params, rivers=replace(params.rivers, uneven=0.0))


def beside(table: RiverTable, count: int, widths: float, seed: int = 4) -> Floats:
    """Points (3, N) on the reference sphere, up to some half widths from lines, before the warp bends these."""
    rng = np.random.default_rng(seed)
    line = rng.choice(np.flatnonzero((table.to >= 0) & (table.values[:, 1] > 0.0)), count)
    step_m = table.cell_m / CELL_STEPS
    a, b = table.place[line] * step_m, table.place[table.to[line]] * step_m
    place = a + rng.uniform(size=(count, 1)) * (b - a)
    side = rng.normal(size=place.shape)
    side /= np.linalg.norm(side, axis=1)[:, None]
    place += side * (table.values[line, 1] * rng.uniform(0.0, widths, count))[:, None]
    return (place * (table.radius_m / np.linalg.norm(place, axis=1))[:, None]).T


def test_far_from_water_nothing_changes(ground: TerrainParams) -> None:
    table = ground.rivers
    assert table is not None
    points = beside(table, 3000, 40.0)
    pairs = river_pairs(table, points)
    assert pairs is not None
    beyond = np.full(points.shape[1], np.inf)
    np.minimum.at(beyond, pairs.where, pairs.d - BANK_FAR * pairs.value[1])
    far = beyond > 0.0
    directions = (points / table.radius_m).T
    uneven, plain = height(directions, ground), height(directions, straight(ground))
    assert far.sum() > 500 and (uneven[far] == plain[far]).all()
    assert (uneven[~far] != plain[~far]).any()


def test_banks_stay_on_the_floor_and_leave_water(ground: TerrainParams) -> None:
    table = ground.rivers
    assert table is not None
    pairs = river_pairs(table, beside(table, 4000, 2.0))
    assert pairs is not None
    half, floor = pairs.value[1], pairs.value[3]
    wet = half > 0.0
    assert (pairs.bank[wet] <= np.maximum(floor, half)[wet] * (1.0 + 1e-9)).all()
    assert (pairs.bank[wet] >= BANK_NARROWEST * half[wet] * (1.0 - 1e-9)).all()
    inside = wet & (pairs.d < half)
    # They wander by a tenth of the half width, or of a lake by what noise of 256 m can.
    assert np.std(pairs.bank[inside] - half[inside]) > 0.02 * min(np.median(half[inside]), 100.0)


def test_levels_know_straight_banks_alone(ground: TerrainParams) -> None:
    table = ground.rivers
    assert table is not None
    points = beside(table, 2000, 1.5)
    a, b = waters(table, points), waters(replace(table, uneven=0.0), points)
    np.testing.assert_array_equal(a.level_m, b.level_m)
    assert (a.beyond_m != b.beyond_m).any() and (a.depth_m != b.depth_m).any()


def test_the_gradient_is_that_of_the_heights_on_banks() -> None:
    params, _ = with_rivers(EARTH)
    table = params.rivers
    assert table is not None
    points = beside(table, 600, 1.6)
    directions = (points / table.radius_m).T
    _, gradient = height_and_gradient(directions, params)
    step_m, numeric = 0.05, np.zeros_like(gradient)
    for axis in range(3):
        off = np.zeros(3)
        off[axis] = step_m / table.radius_m
        ahead, back = (height(directions + s * off, params) for s in (1.0, -1.0))
        numeric[:, axis] = (ahead - back) / (2.0 * step_m)
    level = numeric - directions * (numeric * directions).sum(axis=1)[:, None]
    off = np.linalg.norm(level - gradient, axis=1)
    # Edges are kinks.
    assert np.quantile(off, 0.9) < 2e-3


def test_an_edge_wanders_along_a_straight_line() -> None:
    """The share of half a kilometre of bank that lies more than a metre off its own mean line."""
    params, _ = with_rivers(EARTH)
    table = params.rivers
    assert table is not None
    pairs = river_pairs(table, beside(table, 8000, 1.3))
    assert pairs is not None
    rivers = (pairs.value[5] < 0.5) & (np.abs(pairs.d - pairs.value[1]) < 0.1 * pairs.value[1])
    moved_m = (pairs.bank - pairs.value[1])[rivers]
    assert 0.3 < (np.abs(moved_m) > 5.0).mean() < 0.95 and abs(np.mean(moved_m)) < 8.0


@pytest.mark.parametrize("radius_m", [100.0, *RADII])
def test_wavelengths_are_the_same_on_planets_of_all_sizes(radius_m: float) -> None:
    """Where whole numbers hold them."""
    step_m = float(2.0 ** (np.floor(np.log2(radius_m)) - 8.0) / CELL_STEPS)
    bits = bank_bits(step_m)
    assert all(0 <= b <= 30 for b in bits) and len(set(bits)) == 3
    if radius_m >= 1e3:
        assert [step_m * 2.0**b for b in bits] == [256.0, 64.0, 16.0]


@pytest.mark.gpu
def test_the_drawn_ground_follows_the_knob_to_and_fro() -> None:
    """Also where both tables are known already, so that nothing is solved."""
    with pf.load_scene("earth") as scene, pf.Renderer(scene, (64, 36), "low") as renderer:
        there = renderer.camera_state(pf.view("river", scene.planet))  # on the same place of either ground
        camera = pf.Camera(position_m=there.position_m + 5.0 * there.up, forward=there.forward, up=there.up)
        found = []
        for banks in (1.0, 0.0, 1.0, 0.0):
            scene.planet[pf.Terrain].banks = banks
            renderer.settle(camera)
            found.append(renderer.render(camera, outputs=("distance",))["distance"])
        assert (np.abs(found[1] / found[0] - 1.0) > 0.01).mean() > 0.02
        assert np.array_equal(found[0], found[2]) and np.array_equal(found[1], found[3])
