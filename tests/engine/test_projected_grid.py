"""The projected grid's geometry: what it covers, where its points lie, how it is cut."""

from __future__ import annotations

import numpy as np
import pytest

from planetfall.engine.surface.coverage import coverage
from planetfall.engine.surface.projected_grid import FINEST, MOST_LEVEL, ProjectedGrid, grid_axes, grid_offset

EARTH_M = 6.371e6


def made(altitude_m, corners=100, power=4, highest_m=9000.0, radius_m=EARTH_M, direction=(0.3, -0.5, 0.8)):
    seen = coverage(altitude_m, radius_m, highest_m)
    return ProjectedGrid(corners, power, grid_offset(seen), grid_axes(direction), radius_m), seen


def test_axes_are_right_handed_everywhere():
    directions = np.random.default_rng(1).normal(size=(200, 3))
    for direction in (*directions, *np.eye(3), *-np.eye(3)):
        axes = grid_axes(direction)
        np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-15)
        assert np.linalg.det(axes) > 0.0
        np.testing.assert_allclose(axes[2], direction / np.linalg.norm(direction))


@pytest.mark.parametrize("power", [2, 4])
@pytest.mark.parametrize("altitude_m", [2.0, 1e4, 2e6, 1e9])
def test_covers_all_that_can_be_seen(altitude_m, power):
    grid, seen = made(altitude_m, power=power)
    # The border's rounding is that of an angle of up to two radians in float64.
    assert grid.covered_rad() >= seen.half_angle_rad - 1e-12


def test_covers_a_small_planet_with_high_ground():
    grid, seen = made(5000.0, radius_m=1000.0, highest_m=100.0)
    assert grid.z_s < 0.0 and grid.covered_rad() >= seen.half_angle_rad


def test_printed_offset_without_its_correction_would_not_cover():
    seen = coverage(1e9, 1000.0, 100.0)
    printed = ProjectedGrid(100, 4, seen.z_s, grid_axes((0, 0, 1)), 1000.0)
    assert printed.covered_rad() < seen.half_angle_rad - 0.01


@pytest.mark.parametrize("altitude_m", [0.02, 100.0, 2e6, 36e6])
def test_foot_offsets_have_no_cancellation(altitude_m):
    grid, _ = made(altitude_m)
    i, j = np.random.default_rng(2).integers(0, grid.steps() + 1, (2, 4000))
    exact = grid.planar(i, j).astype(np.longdouble)
    exact /= np.sqrt((exact**2).sum(axis=1, keepdims=True))
    exact[:, 2] -= 1
    exact = (exact @ grid.axes.astype(np.longdouble)) * EARTH_M
    off = np.linalg.norm(grid.foot_offsets_m(i, j) - exact, axis=1)
    assert (off <= 4e-16 * np.linalg.norm(exact, axis=1) + 1e-18 * EARTH_M).all()
    np.testing.assert_allclose(grid.directions(i, j), exact / EARTH_M + grid.axes[2], atol=1e-15)


def test_patches_beside_one_another_share_the_cut_of_their_edge():
    grid, _ = made(100.0)
    cut = grid.tessellate(100.0, 0.0, 12.0e-3)
    levels = np.zeros((grid.patches, grid.patches, 4), int)
    levels[cut.i, cut.j] = cut.edge_level
    assert (levels[1:, :, 0] == levels[:-1, :, 1]).all() and (levels[:, 1:, 2] == levels[:, :-1, 3]).all()
    assert (cut.level == cut.edge_level.max(axis=1)).all()
    assert (np.diff(cut.level) <= 0).all()
    assert cut.level.max() == MOST_LEVEL and cut.level.min() <= 1
    assert cut.vertices == cut.first[-1] + (2 ** cut.level[-1] + 1) ** 2
    words = cut.packed()
    assert (words[:, 0] & 255 == cut.i).all() and (words[:, 0] >> 8 & 255 == cut.j).all()
    assert (words[:, 0] >> 16 & 7 == cut.level).all() and (words[:, 1] == cut.first).all()
    for edge in range(4):
        assert (words[:, 0] >> (19 + 3 * edge) & 7 == cut.edge_level[:, edge]).all()


def test_segments_keep_to_the_wanted_size():
    grid, _ = made(2e6)
    wanted = 0.01
    cut = grid.tessellate(2e6, 0.0, wanted)
    place = np.stack([cut.i, cut.j], axis=1) * FINEST
    a = grid.foot_offsets_m(place[:, 0], place[:, 1])
    b = grid.foot_offsets_m(place[:, 0], place[:, 1] + FINEST)  # edge 0: at i, along j
    away = np.linalg.norm(0.5 * (a + b) - 2e6 * grid.axes[2], axis=1)
    angle = np.linalg.norm(a - b, axis=1) / away / 2.0 ** cut.edge_level[:, 0]
    assert (angle <= wanted * (1 + 1e-9)).all()
    assert (angle[cut.edge_level[:, 0] > 0] > 0.5 * wanted * (1 - 1e-9)).all()


def test_there_are_never_too_many_vertices():
    grid, _ = made(1e4, corners=200)
    cut = grid.tessellate(1e4, 0.0, 1e-6, most_vertices=300_000)
    assert cut.vertices <= 300_000 and cut.coarser > 1.0


@pytest.mark.parametrize("power", [2, 4])
@pytest.mark.parametrize("altitude_m", [2.0, 1e4, 2e6, 1e9])
def test_places_are_found_again(altitude_m, power):
    grid, seen = made(altitude_m, power=power)
    # Near its corners the grid turns inside out where z_s is negative.
    border = grid.steps() // 8
    i, j = np.random.default_rng(4).integers(border, grid.steps() - border, (2, 3000))
    np.testing.assert_allclose(grid.locate(grid.directions(i, j)), np.stack([i, j], axis=1), atol=1e-9)
    beyond = np.cos(seen.half_angle_rad + 0.3) * grid.axes[2] + np.sin(seen.half_angle_rad + 0.3) * grid.axes[0]
    assert np.isnan(grid.locate(np.stack([-grid.axes[2], beyond]))[0 if altitude_m > 1e8 else slice(None)]).all()
