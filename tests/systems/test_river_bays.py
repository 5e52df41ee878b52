"""Bays that the drainage's cells don't show: rivers come down to the sea where it comes in, and stay down."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from planetfall.engine.table_cache import TableCache
from planetfall.systems.terrain.drainage.climate import ClimateParams
from planetfall.systems.terrain.drainage.solve import solve_streams
from planetfall.systems.terrain.height import TerrainParams, height
from planetfall.systems.terrain.rivers.bays import PARTS, Bays, bays_of, find_bays, with_bays
from planetfall.systems.terrain.rivers.bends import bend_amplitudes_m, bend_lattice, river_cell_m, unbent
from planetfall.systems.terrain.rivers.node_arrays import RiverNodes
from planetfall.systems.terrain.rivers.nodes import nodes_of
from planetfall.systems.terrain.rivers.table import river_table
from planetfall.systems.terrain.rivers.valleys import waters

Floats = NDArray[np.float64]
EARTH = TerrainParams(6.371e6, 1, 9000.0, -9000.0, layers=12, land_share=0.3, hills=0.2, mountains=0.4)
CELLS = 40_000
CLIMATE = ClimateParams(5200.0, -500.0, 0.5)


@pytest.fixture(scope="module")
def plain() -> RiverNodes:
    """Without a look for bays."""
    made = solve_streams(EARTH, CLIMATE, CELLS)
    return nodes_of(made.network.grid, made.streams, EARTH)


@pytest.fixture(scope="module")
def found(plain: RiverNodes) -> Bays:
    return find_bays(plain, EARTH, CELLS)


@pytest.fixture(scope="module")
def cut(plain: RiverNodes, found: Bays) -> RiverNodes:
    return with_bays(plain, found)


def walls_m(nodes: RiverNodes, count: int = 12_000) -> Floats:
    """Of places in rivers more than 1 m above the sea: how high their water stands above that, where it lies beside
    them; else 0."""
    table = river_table(nodes, EARTH.radius_m, EARTH.seed)
    ground = replace(EARTH, rivers=table)
    rng = np.random.default_rng(5)
    to = nodes.to
    line = np.flatnonzero((to >= 0) & (nodes.half_width_m > 0.0) & ~(nodes.lake & nodes.lake[to]))
    length = np.linalg.norm(nodes.direction[line] - nodes.direction[to[line]], axis=1)
    line = rng.choice(line, count, p=length / length.sum())
    t = rng.uniform(0.0, 1.0, count)
    way = nodes.direction[to[line]] - nodes.direction[line]
    place = (nodes.direction[line] + t[:, None] * way) * EARTH.radius_m
    side = np.cross(place, way)
    side /= np.linalg.norm(side, axis=1)[:, None]
    half = nodes.half_width_m[line] * (1.0 - t) + nodes.half_width_m[to[line]] * t

    def at(points: Floats) -> tuple[Floats, NDArray[np.bool_], Floats]:
        there = unbent(points.T, EARTH.radius_m, EARTH.seed)
        water, ground_m = waters(table, there), height(there.T / EARTH.radius_m, ground)
        return water.level_m, (water.beyond_m < 0.0) & (water.level_m > ground_m), ground_m

    level, wet, _ = at(place)
    level = np.where(wet, level, 0.0)
    beside = np.zeros(count, dtype=bool)
    for sign in (-1.0, 1.0):
        _, river, ground_m = at(place + sign * side * (1.15 * half + 3.0)[:, None])
        beside |= ~river & (ground_m < 0.0)
    return np.where(beside, level, 0.0)[level > 1.0]


def test_no_water_stands_as_a_wall_above_the_sea(plain: RiverNodes, cut: RiverNodes) -> None:
    before, after = walls_m(plain), walls_m(cut)
    assert (before > 0.0).mean() > 0.005 and before.max() > 20.0
    assert (after > 0.0).mean() < 0.2 * (before > 0.0).mean()


def test_levels_only_fall_and_never_climb(plain: RiverNodes, cut: RiverNodes, found: Bays) -> None:
    count, added = len(plain), len(cut) - len(plain)
    assert added == np.count_nonzero(found.part) > 50
    assert (cut.level_m[:count] <= plain.level_m).all()
    upper = np.flatnonzero(cut.to >= 0)
    assert (cut.level_m[upper] >= cut.level_m[cut.to[upper]]).all()
    # Nothing but levels changes, and ways only get a node more.
    for name in ("direction", "half_width_m", "depth_m", "flat_m", "reach_m", "lake", "discharge_m3_s"):
        assert np.array_equal(getattr(cut, name)[:count], getattr(plain, name)), name
    line = found.line[found.part > 0]
    assert np.array_equal(cut.to[line], np.arange(count, len(cut)))
    assert np.array_equal(cut.to[count:], plain.to[line])
    share = np.linalg.norm(cut.direction[count:] - plain.direction[line], axis=1)
    share /= np.linalg.norm(plain.direction[plain.to[line]] - plain.direction[line], axis=1)
    assert share == pytest.approx(found.part[found.part > 0] / PARTS, abs=1e-3)
    # From there on all water is the sea's.
    below = np.unique(cut.to[count:])
    while below.size:
        assert (cut.level_m[below] <= 0.0).all()
        below = np.unique(cut.to[below])
        below = below[below >= 0]


def test_no_bay_lies_above_a_lake(plain: RiverNodes, cut: RiverNodes, found: Bays) -> None:
    """It would have to stand as high as the lake does."""
    first = int(found.line[0])
    below = plain.to[plain.to[first]]
    assert below >= 0
    lake = np.zeros_like(plain.lake)
    lake[below] = True
    held = find_bays(replace(plain, lake=lake), EARTH, CELLS)
    assert 0 < len(held.line) < len(found.line) and first not in held.line
    assert with_bays(plain, held).level_m[below] == plain.level_m[below] > cut.level_m[below] - 1.0


def test_what_is_found_is_kept(plain: RiverNodes, found: Bays, tmp_path) -> None:
    cache = TableCache("drainage", tmp_path)
    first = bays_of(lambda: plain, EARTH, CELLS, "some rivers", cache)

    def never() -> RiverNodes:
        raise AssertionError

    again = bays_of(never, EARTH, CELLS, "some rivers", cache)
    for kept in (first, again):
        assert np.array_equal(kept.line, found.line) and np.array_equal(kept.part, found.part)
        assert kept.part.dtype == np.uint8 and kept.line.dtype == np.int32


def test_the_inverse_of_the_warp() -> None:
    rng = np.random.default_rng(2)
    points = rng.normal(size=(3, 5000))
    points *= EARTH.radius_m / np.linalg.norm(points, axis=0)
    places = unbent(points, EARTH.radius_m, 1)
    cell_m = river_cell_m(EARTH.radius_m)
    moves = bend_amplitudes_m(cell_m)[:, None] * bend_lattice(cell_m, 1).cells(places).vector()
    off = places + moves.sum(axis=1) - points
    off -= points * ((points * off).sum(axis=0) / EARTH.radius_m**2)
    off_m = np.linalg.norm(off, axis=0)
    assert np.linalg.norm(places - points, axis=0).max() > 500.0
    assert np.quantile(off_m, 0.9) < 60.0


@pytest.mark.parametrize("make", [lambda n: n, lambda n: replace(n, half_width_m=np.zeros_like(n.half_width_m))])
def test_nothing_to_find(plain: RiverNodes, make: Callable[[RiverNodes], RiverNodes]) -> None:
    """Dry valleys, and rivers high in the land."""
    high = replace(make(plain), level_m=plain.level_m + np.float32(5000.0))
    none = find_bays(high, EARTH, CELLS)
    assert none.line.shape == none.part.shape == (0,)
    assert len(with_bays(high, none)) == len(high)
