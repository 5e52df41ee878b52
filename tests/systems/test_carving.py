"""Levels of rivers: what the stream power law cuts, passes that are cut through, and hollows that hold lakes."""

from __future__ import annotations

import numpy as np
import pytest

from planetfall.systems.terrain.drainage.carve import Carved, CellGround, carve, lowered
from planetfall.systems.terrain.drainage.cells import cell_grid
from planetfall.systems.terrain.drainage.routing import add_downstream

CELL_M = 12e3


def row(heights: list[float], water_m: float = 0.36) -> CellGround:
    """Cells one after the other, the first the sea's."""
    count = len(heights)
    neighbours = np.full((count, 8), -1, dtype=np.int64)
    neighbours[1:, 0], neighbours[:-1, 1] = np.arange(count - 1), np.arange(1, count)
    sea = np.zeros(count, dtype=bool)
    sea[0] = True
    return CellGround(
        np.array(heights), sea, neighbours, np.full((count, 8), CELL_M), np.full(count, CELL_M**2),
        np.full(count, water_m),
    )  # fmt: skip


def random_ground(seed: int, water_m: float) -> CellGround:
    """Full of hollows, on a small sphere of cells."""
    grid, rng = cell_grid(20), np.random.default_rng(seed)
    neighbours = grid.neighbours(np.arange(grid.count, dtype=np.int32)).astype(np.int64)
    height = 600.0 * rng.normal(size=grid.count) + 500.0
    sea = height < 0.0
    return CellGround(
        np.where(sea, 0.0, height), sea, neighbours, np.full(neighbours.shape, CELL_M),
        np.full(grid.count, CELL_M**2), np.full(grid.count, water_m),
    )  # fmt: skip


def check(ground: CellGround, made: Carved) -> None:
    """What holds of any ground."""
    receiver = made.flow.receiver
    assert (made.level_m >= made.level_m[receiver]).all() and (made.level_m >= 0.0).all()
    assert (made.level_m[ground.sea] == 0.0).all() and not made.lake[ground.sea].any()
    inside = made.lake & made.lake[receiver]
    assert (made.level_m[inside] == made.level_m[receiver[inside]]).all()
    assert (made.floor_m <= made.level_m).all() and (made.floor_m[made.lake] < made.level_m[made.lake]).all()


def test_without_hollows_and_time_nothing_is_cut() -> None:
    ground = row([0.0, 10.0, 30.0, 80.0, 200.0])
    made = carve(ground, 0.0)
    assert np.array_equal(made.level_m, ground.low_m) and not made.lake.any()


def test_the_last_steps_go_as_the_law_says() -> None:
    """Cells next to the sea: dz/dt = -K sqrt(A) z / dx, in three implicit steps; water of the mean counts whole."""
    ground = row([0.0, 10.0, 30.0, 80.0, 200.0])
    factor = 1.5 / 3.0 * np.sqrt(4.0 * CELL_M**2) / CELL_M
    assert carve(ground, 1.5).level_m[1] == pytest.approx(10.0 / (1.0 + factor) ** 3, rel=1e-12)
    # Without rain a quarter of the land counts.
    dry = carve(row([0.0, 10.0, 30.0, 80.0, 200.0], 0.0), 1.5)
    assert dry.level_m[1] == pytest.approx(10.0 / (1.0 + 0.5 * factor) ** 3, rel=1e-12)


def test_rivers_become_concave() -> None:
    """From an even slope: steepest at the spring, flattest at the sea, as catchments grow downstream."""
    ground = row([20.0 * k for k in range(60)])
    slope = np.diff(carve(ground, 2.0).level_m)
    assert (np.diff(slope[:50]) > 0.0).all() and slope[50] > 3.0 * slope[0]


def test_no_river_lies_much_deeper_than_1500_m() -> None:
    high = row([0.0, *[5000.0] * 30])
    high.low_m[1:] += np.arange(30.0)
    made = carve(high, 1000.0)
    assert (high.low_m - made.level_m).max() == pytest.approx(1500.0)


def test_passes_of_dry_hollows_are_cut_and_wet_ones_hold_lakes() -> None:
    heights = [0.0, 300.0, 100.0, 90.0, 320.0, 400.0]
    dry = carve(row(heights, 0.0), 0.0)
    assert not dry.lake.any()
    assert dry.level_m.tolist() == [0.0, 90.0, 90.0, 90.0, 320.0, 400.0]
    wet = carve(row(heights, 3.0), 0.0)
    assert wet.lake.tolist() == [False, False, True, True, False, False]
    assert wet.level_m.tolist() == [0.0, 300.0, 300.0, 300.0, 320.0, 400.0]
    assert wet.floor_m[wet.lake].tolist() == [100.0, 90.0]
    # A river that cuts the pass lowers the lake, and at last empties it.
    lower = carve(row(heights, 3.0), 0.1)
    assert lower.lake[2:4].all() and 100.0 < lower.level_m[2] < 300.0
    check(row(heights, 3.0), lower)
    assert not carve(row(heights, 3.0), 10.0).lake.any()


def test_puddles_and_seas_are_no_lakes() -> None:
    assert not carve(row([0.0, 300.0, 250.0, 320.0], 3.0), 0.0).lake.any()  # 50 m deep
    wide = [0.0, 300.0, *[100.0 + 0.01 * k for k in range(301)], 400.0]
    assert not carve(row(wide, 3.0), 0.0).lake.any()
    assert carve(row([*wide[:300], 400.0], 3.0), 0.0).lake.sum() == 298


@pytest.mark.parametrize("water_m", [0.0, 0.5, 3.0])
@pytest.mark.parametrize("incision", [0.0, 0.2, 2.0])
def test_any_ground_gets_levels(incision: float, water_m: float) -> None:
    lakes = 0
    for seed in range(3):
        ground = random_ground(seed, water_m)
        made = carve(ground, incision)
        check(ground, made)
        outlet = made.flow.receiver[made.lake]
        assert np.array_equal(made.level_m[made.lake], made.level_m[outlet])
        comes = add_downstream(made.flow, np.where(ground.sea, 0.0, ground.area_m2))
        assert comes[ground.sea].sum() == pytest.approx(ground.area_m2[~ground.sea].sum())
        lakes += int(made.lake.sum())
        # Lower ground lowers rivers, not lakes.
        less = lowered(made, 0.5 * ground.low_m)
        check(ground, less)
        assert np.array_equal(less.lake, made.lake)
        assert np.array_equal(less.level_m[made.lake], made.level_m[made.lake])
        assert (less.level_m <= made.level_m).all()
    assert (lakes > 0) == (water_m > 0.0 and incision < 1.0)
