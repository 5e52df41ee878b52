"""Tiles read on one grid: the files' own samples, several sets, gaps, boxes, other projections, coarser cells."""

from __future__ import annotations

import numpy as np
import pytest
from countries import hgt_samples, land, write_country, write_hgt, write_png_tile

from planetfall.engine.real_ground.height_grid import height_grid
from planetfall.engine.real_ground.tile_files import TileError

RADIUS_M = 6.371e6


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path / "cache"))


def test_cells_are_the_samples_of_the_files(tmp_path):
    write_country(tmp_path / "tiles", 46, 7, 1, 2, 61)
    grid = height_grid(str(tmp_path / "tiles"), "x", RADIUS_M)
    assert grid.height_m.shape == (61, 121)
    np.testing.assert_allclose(grid.latitude_deg, 47.0 - np.arange(61) / 60.0, atol=1e-9)
    np.testing.assert_allclose(grid.longitude_deg, 7.0 + np.arange(121) / 60.0, atol=1e-9)
    np.testing.assert_array_equal(grid.height_m[:, :61], hgt_samples(46, 7, 61))
    np.testing.assert_array_equal(grid.height_m[:, 60:], hgt_samples(46, 8, 61))
    assert abs(grid.step_m - np.radians(1.0 / 60.0) * RADIUS_M) < 1e-6 and grid.own_m == grid.step_m
    np.testing.assert_allclose(grid.edge_deg, 47.0 - (np.arange(62) - 0.5) / 60.0, atol=1e-9)
    np.testing.assert_allclose(grid.degrees(np.array([1.5]), np.array([2.25])), [[7.0 + 1.5 / 60, 47.0 - 2.25 / 60]])


@pytest.mark.parametrize("by", [2, 3, 8])
def test_coarser_cells_are_means(tmp_path, by):
    write_hgt(tmp_path / "tiles", 46, 7, 241)
    own_m = np.radians(1.0 / 240.0) * RADIUS_M
    grid = height_grid(str(tmp_path / "tiles"), "x", RADIUS_M, spacing_m=by * own_m)
    side = 241 // by
    assert grid.height_m.shape == (side, side) and abs(grid.step_m - by * own_m) < 1e-6
    samples = hgt_samples(46, 7, 241)[: side * by, : side * by].astype(np.float64)
    means = samples.reshape(side, by, side, by).mean(axis=(1, 3))
    inner = (slice(2, -2), slice(2, -2))
    most = 1e-3 if by <= 4 else 0.05 * np.ptp(samples)
    np.testing.assert_allclose(grid.height_m[inner], means[inner], atol=most)
    few = height_grid(str(tmp_path / "tiles"), "x", RADIUS_M, most_cells=(241 // by) ** 2)
    np.testing.assert_array_equal(few.height_m, grid.height_m)


def test_a_box_reads_its_tiles_alone(tmp_path):
    path = write_country(tmp_path / "tiles", 44, 5, 4, 4, 31)
    (path / "N44E005.hgt").write_bytes(b"broken")
    box = (6.5, 45.4, 7.6, 46.3)
    grid = height_grid(str(path), "x", RADIUS_M, box)
    assert grid.longitude_deg[0] >= box[0] and grid.longitude_deg[-1] <= box[2]
    assert grid.latitude_deg[0] <= box[3] and grid.latitude_deg[-1] >= box[1]
    assert grid.height_m.shape == (28, 34) and not np.isnan(grid.height_m).any()
    latitude, longitude = np.meshgrid(grid.latitude_deg, grid.longitude_deg, indexing="ij")
    np.testing.assert_array_equal(grid.height_m, np.rint(land(latitude, longitude)))


def test_coarse_sets_lie_below_fine_ones_and_wide_gaps_are_none(tmp_path):
    write_country(tmp_path / "coarse", 46, 7, 1, 2, 61)
    fine = hgt_samples(46, 7, 241)
    fine[100:102, 50:52] = -32768
    fine[20:90, 120:200] = -32768
    write_hgt(tmp_path / "fine", 46, 7, 241, fine)
    both = height_grid(str(tmp_path), "x", RADIUS_M)
    assert both.height_m.shape == (241, 481) and not np.isnan(both.height_m).any()
    alone = height_grid(str(tmp_path / "fine"), "x", RADIUS_M)
    there = fine != -32768
    np.testing.assert_array_equal(alone.height_m[there], fine[there])
    # The small one is closed, the wide one but for its margin not.
    assert not np.isnan(alone.height_m[100:102, 50:52]).any()
    assert np.isnan(alone.height_m[30:80, 130:190]).all()
    latitude, longitude = np.meshgrid(both.latitude_deg, both.longitude_deg, indexing="ij")
    assert np.abs(both.height_m - land(latitude, longitude)).max() < 40.0


def test_mercator_tiles_keep_their_rows(tmp_path):
    for x in (2133, 2134):
        write_png_tile(tmp_path / "tiles", 12, x, 1448, 64)
    grid = height_grid(str(tmp_path / "tiles"), "x", RADIUS_M)
    assert grid.height_m.shape == (64, 128)
    latitude, longitude = np.meshgrid(grid.latitude_deg, grid.longitude_deg, indexing="ij")
    np.testing.assert_allclose(grid.height_m, land(latitude, longitude), atol=0.051)
    south_m = -np.radians(np.diff(grid.latitude_deg)) * RADIUS_M
    np.testing.assert_allclose(south_m, grid.step_m, rtol=2e-3)
    east_m = grid.column_rad * RADIUS_M * np.cos(np.radians(grid.latitude_deg[32]))
    np.testing.assert_allclose(east_m, grid.step_m, rtol=1e-3)


@pytest.mark.parametrize(
    ("box", "words"),
    [
        ((10.0, 46.0, 11.0, 47.0), "no tile of"),
        ((8.0, 46.0, 7.0, 47.0), "west below east"),
        ((7.0, 46.0, 8.0, 146.0), "in -90 to 90"),
        ((7.0, 46.0, 7.001, 46.001), "expected 3 x 3"),
    ],
)
def test_boxes_that_hold_nothing(tmp_path, box, words):
    write_hgt(tmp_path / "tiles", 46, 7, 31)
    with pytest.raises(TileError, match=words):
        height_grid(str(tmp_path / "tiles"), "x", RADIUS_M, box)
