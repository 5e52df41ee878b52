"""Where the printed grid lies: held, moved by its own cells, placed anew; and what of it is found again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from planetfall.benchmarks.measure.grid_kept import Sight, kept, level_flight, most_points
from planetfall.engine.surface.coverage import coverage
from planetfall.engine.surface.grid_place import CELLS, MOST_CELLS, cell_rad, placed, reach_rad
from planetfall.engine.surface.projected_grid import FINEST, grid_axes

RADIUS_M = 6.371e6
FOOT = np.array([0.3, -0.5, 0.8]) / np.linalg.norm([0.3, -0.5, 0.8])


def grid_at(camera, held=None, altitude_m=1e4, power=4):
    return placed(held, FOOT, camera, coverage(altitude_m, RADIUS_M, 9000.0), 100, power, RADIUS_M)


def aside(grid, cells_u, cells_v=0.0):
    """The direction so many cells from the middle."""
    cell = cell_rad(grid.z_s, grid.corners)
    found = grid.axes[2] + np.tan(cells_u * cell) * grid.axes[0] + np.tan(cells_v * cell) * grid.axes[1]
    return found / np.linalg.norm(found)


@pytest.mark.parametrize("cells", [(0.0, 0.0), (0.65, 0.0), (-0.6, 0.69), (0.1, -0.69)])
def test_it_is_held_within_its_cells(cells):
    grid = grid_at(FOOT)
    assert grid_at(aside(grid, *cells), grid) is grid


@pytest.mark.parametrize(("cells", "steps"), [((0.8, 0.0), (1, 0)), ((-0.8, 0.2), (-1, 0)), ((0.0, 0.75), (0, 1))])
def test_it_moves_by_a_whole_cell_at_the_same_offset(cells, steps):
    grid = grid_at(FOOT)
    moved = grid_at(aside(grid, *cells), grid)
    half = grid.steps() // 2
    assert moved.z_s == grid.z_s
    # Its middle is the old grid's point beside the middle.
    wanted = grid.directions(half + FINEST * steps[0], half + FINEST * steps[1])
    np.testing.assert_allclose(moved.axes[2], wanted, atol=1e-14)
    np.testing.assert_allclose(moved.axes @ moved.axes.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(moved.axes) > 0.0


def test_after_a_long_flight_it_still_stands_upright():
    grid = grid_at(FOOT)
    for _ in range(3000):
        grid = grid_at(aside(grid, 0.9, 0.8), grid)
    np.testing.assert_allclose(grid.axes @ grid.axes.T, np.eye(3), atol=1e-15)


def test_a_cut_and_another_height_place_it_anew():
    grid = grid_at(FOOT)
    far = grid_at(aside(grid, MOST_CELLS + 2.0), grid)
    np.testing.assert_allclose(far.axes, grid_axes(aside(grid, MOST_CELLS + 2.0)), atol=1e-15)
    assert grid_at(FOOT, grid, altitude_m=1.02e4) is grid, "a little higher is covered"
    assert grid_at(FOOT, grid, altitude_m=2e5).z_s < grid.z_s
    assert grid_at(FOOT, grid_at(FOOT, altitude_m=2e5)).z_s == grid.z_s, "far too wide a grid is not kept"


@pytest.mark.parametrize("power", [4, 2])
@pytest.mark.parametrize("altitude_m", [2.0, 100.0, 1e4, 4e5, 2e6, 1e7])
def test_what_a_camera_sees_is_covered_wherever_it_is(altitude_m, power):
    grid = grid_at(FOOT, altitude_m=altitude_m, power=power)
    seen = coverage(altitude_m, RADIUS_M, 9000.0)
    assert grid.covered_rad() >= min(seen.half_angle_rad + np.sqrt(2.0) * CELLS * cell_rad(grid.z_s, 100), 3.0)
    assert reach_rad(grid.z_s, 100) < 0.5 * seen.half_angle_rad


@pytest.mark.parametrize(("altitude_m", "least"), [(100.0, 0.8), (1e4, 0.65)])
def test_most_vertices_are_found_again(altitude_m, least):
    assert min(k.vertices for k in level_flight(Sight(altitude_m), 3)) >= least


def test_far_away_as_many_points_are_found_again_as_any_move_keeps():
    """The warp leaves no more: of all moves by half a cell up to two, turned a little or not, one cell is the best."""
    sight = Sight(2e6)
    points = min(k.points for k in level_flight(sight, 2))
    most, step = most_points(sight, steps=8)
    assert points >= 0.3
    assert step == (1.0, 0.0, 0.0) and points == pytest.approx(most, abs=1e-3)


def test_a_grid_elsewhere_is_not_found_again():
    """The measure itself: 0.4 of a cell farther nothing of the grid's points lies on an old one."""
    sight = Sight(1e4)
    grid = sight.grid(None, FOOT)
    other = replace(grid, axes=grid_axes(aside(grid, 0.4, 0.4)))
    assert kept(sight, grid, other, (FOOT, other.axes[2])).points < 0.1
    assert kept(sight, grid, grid, (FOOT, FOOT)).vertices == 1.0
