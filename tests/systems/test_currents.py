"""How water flows: along its banks, downhill, on through bends, and through lakes into the rivers that leave them."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

import planetfall as pf
from planetfall.components import Ocean, Planet, Terrain
from planetfall.systems.terrain.drainage.climate import climate_params
from planetfall.systems.terrain.height_params import TerrainParams
from planetfall.systems.terrain.rivers.form import BANK_NARROWEST
from planetfall.systems.terrain.rivers.nodes import rivers_of_ground
from planetfall.systems.terrain.rivers.pairs import river_pairs
from planetfall.systems.terrain.rivers.table import CELL_STEPS, RiverTable, river_table
from planetfall.systems.terrain.rivers.valleys import Waters, waters

Floats = NDArray[np.float64]
CELLS = 40_000
MOST = 0.9 * BANK_NARROWEST
"""Of the half width: so near to the middle there is water, however banks draw in."""


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RiverTable]:
    """The preset earth's rivers on few cells."""
    with pytest.MonkeyPatch.context() as patch, pf.load_scene("earth") as scene:
        if "PLANETFALL_CACHE" not in os.environ:
            patch.setenv("PLANETFALL_CACHE", str(tmp_path_factory.mktemp("cache")))
        terrain, radius_m = scene.planet[Terrain], scene.planet[Planet].radius_m
        params = TerrainParams.from_component(terrain, radius_m)
        nodes = rivers_of_ground(params, climate_params(terrain, scene.planet.get(Ocean) is not None), CELLS)
        assert nodes is not None
        yield river_table(nodes, radius_m, params.seed)


def bent(table: RiverTable, points: Floats) -> Floats:
    """Where the warp moves points (3, N)."""
    return points + (table.bend_m[:, None] * table.bends.cells(points).vector()).sum(axis=1)


def beside_lines(table: RiverTable, lines: NDArray[np.int64], share: Floats, aside: Floats) -> Floats:
    """Points (3, N) on the reference sphere that the warp moves to a share of lines, so many half widths aside."""
    a, b = (table.place[n] * (table.cell_m / CELL_STEPS) for n in (lines, table.to[lines]))
    half = (1.0 - share) * table.values[lines, 1] + share * table.values[table.to[lines], 1]
    goal = a + (b - a) * share[:, None]
    side = np.cross(goal, b - a)
    goal = goal + side / np.linalg.norm(side, axis=1)[:, None] * (aside * half)[:, None]
    points = goal.T
    for _ in range(80):
        points = points * (table.radius_m / np.linalg.norm(points, axis=0))
        off, up = goal.T - bent(table, points), points / table.radius_m
        points = points + 0.5 * (off - up * (up * off).sum(axis=0))
    return points * (table.radius_m / np.linalg.norm(points, axis=0))


def lines_of(table: RiverTable, lake: bool) -> NDArray[np.int64]:
    """With water at both ends."""
    line = np.flatnonzero(table.to >= 0)
    to = table.to[line]
    wet = (table.values[line, 1] > 0.0) & (table.values[to, 1] > 0.0)
    return line[wet & ((table.values[line, 5] * table.values[to, 5] > 0.0) == lake)]


def share_of_width(table: RiverTable, points: Floats) -> Floats:
    """(N,) from the middle of the nearest water, 0, to its bank, 1."""
    pairs = river_pairs(table, points, False)
    assert pairs is not None
    share = np.where(pairs.bank > 0.0, pairs.d / np.maximum(pairs.bank, 1e-9), np.inf)
    found = np.full(points.shape[1], np.inf)
    found[pairs.near] = np.minimum.reduceat(share, pairs.first)
    return found


def level_m(table: RiverTable, points: Floats) -> Floats:
    return waters(table, points).level_m


def gradient(table: RiverTable, points: Floats, of: Callable[[RiverTable, Floats], Floats]) -> Floats:
    """(3, N) along the ground of a number (N,) of places."""
    step_m = 0.02
    found = np.zeros_like(points)
    for axis in range(3):
        off = step_m * np.eye(3)[:, axis, None]
        ahead, back = (of(table, points + sign * off) for sign in (1.0, -1.0))
        found[axis] = (ahead - back) / (2.0 * step_m)
    up = points / table.radius_m
    return found - up * (up * found).sum(axis=0)


@pytest.fixture(scope="module")
def in_rivers(table: RiverTable) -> tuple[Floats, Waters]:
    rng = np.random.default_rng(1)
    lines = rng.choice(lines_of(table, lake=False), 3000)
    points = beside_lines(table, lines, rng.uniform(0.0, 1.0, 3000), rng.uniform(-MOST, MOST, 3000))
    found = waters(table, points)
    assert (found.beyond_m < 0.0).mean() > 0.99
    return points[:, found.beyond_m < 0.0], waters(table, points[:, found.beyond_m < 0.0])


def test_water_flows_along_its_banks(table: RiverTable, in_rivers: tuple[Floats, Waters]) -> None:
    points, found = in_rivers
    speed = np.linalg.norm(found.current_m_s, axis=0)
    assert (speed > 0.0).all(), "not even outside of a bend does it stand"
    assert speed.max() <= 7.5
    # Level, but for what rounds where a place is less than a metre from the line.
    assert np.abs((found.current_m_s * points).sum(axis=0) / table.radius_m).max() < 1e-7
    # A place's share of the width is the same all along its way, wherever banks draw in.
    aside = gradient(table, points, share_of_width)
    length = np.linalg.norm(aside, axis=0)
    half = np.abs(found.beyond_m) + 1.0
    clear = length * half > 0.2
    across = np.abs((found.current_m_s * aside).sum(axis=0) / (speed * np.maximum(length, 0.2 / half)))[clear]
    # But where a river joins another, or turns.
    assert np.percentile(across, 90) < 0.01


def test_water_flows_downhill(table: RiverTable, in_rivers: tuple[Floats, Waters]) -> None:
    points, found = in_rivers
    speed = np.linalg.norm(found.current_m_s, axis=0)
    climbs = (found.current_m_s * gradient(table, points, level_m)).sum(axis=0) / speed
    # Levels are means of the lines about; 1e-6 is what differences of float64 leave.
    assert (climbs > 1e-6).mean() < 0.005
    assert climbs.max() < 1e-3


def test_mouths_are_open(table: RiverTable) -> None:
    """Down the middle of the last stretch, from the river out into the sea, there is water all the way."""
    end = np.flatnonzero((table.to < 0) & (table.values[:, 6] > 100.0))
    last = np.flatnonzero(np.isin(table.to, end))
    mouths = np.flatnonzero(np.isin(table.to, last) & (table.values[:, 1] > 0.0))
    assert len(mouths) > 50
    with pf.load_scene("earth") as scene:
        scene.planet[Terrain].drainage_cells = CELLS
        sampler = pf.TerrainSampler(scene)
    shut = 0
    for mouth in mouths[:60]:
        points = np.concatenate([
            beside_lines(table, np.full(40, mouth), np.linspace(0.98, 1.0, 40), np.zeros(40)),
            beside_lines(table, np.full(120, table.to[mouth]), np.linspace(0.0, 1.0, 120), np.zeros(120)),
        ], axis=1)  # fmt: skip
        water = sampler.water(points.T)
        shut += bool((water.depth_m <= 0.2).any())
    assert shut <= 1


def test_lakes_drain_into_their_rivers(table: RiverTable) -> None:
    """From all over a lake water comes to where its river leaves, over no rim."""
    lakes = lines_of(table, lake=True)
    outlets = lakes[(table.to[table.to[lakes]] >= 0) & (table.values[table.to[table.to[lakes]], 5] == 0.0)]
    assert len(outlets) >= 1
    for line in outlets:
        edge = table.to[line]
        half = float(table.values[edge, 1])
        river = table.values[table.to[edge]]
        # Down the river from its lake, out to three of its half widths.
        length = np.linalg.norm((table.place[table.to[edge]] - table.place[edge]) * (table.cell_m / CELL_STEPS))
        away = np.linspace(0.0, 3.0, 61) * half / length
        points = beside_lines(table, np.full(61, edge), away, np.zeros(61))
        depth = waters(table, points).depth_m
        own = min(float(table.values[edge, 2]), float(river[2]))
        # Where the lake's rim lies across the river both count alike.
        assert depth.min() > 0.45 * own
