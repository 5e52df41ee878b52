"""Masks of water under tiles of elevation: the sea of SRTM, 0 m, goes below the planet's."""

from __future__ import annotations

import logging

import numpy as np
import pytest
from countries import tile_at, tile_places, write_hgt, write_picture
from geotiffs import of_code, pixel_places, write_geotiff

import planetfall as pf

COAST_DEG = 7.5


def shore(latitude_deg):
    """Longitude of the coast, the sea in the west of it."""
    return COAST_DEG + 0.03 * np.sin(40.0 * latitude_deg)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("coast")
    step = np.arange(601) / 600.0
    longitude, latitude = np.meshgrid(7.0 + step, 47.0 - step)
    land = np.maximum(np.rint(200.0 * (longitude - shore(latitude))), 0.0)
    write_hgt(folder / "heights", 46, 7, 601, land.astype(np.int16))
    x, y = tile_at(9, 46.5, 7.5)
    for dx in (-1, 0, 1):
        for dy in (-1, 0, 1):
            latitude, longitude = tile_places(9, x + dx, y + dy)
            wet = np.where(longitude < shore(latitude), 255, 0).astype(np.uint8)
            write_picture(folder / "sea", 9, x + dx, y + dy, wet)
    (folder / "map.toml").write_text(
        '[[tiles]]\nfolder = "heights"\n[[tiles]]\nfolder = "sea"\nkind = "water"\ndepth_m = 6.0\n'
    )
    return folder


def heights_of(path, latitude_deg, longitude_deg):
    scene = pf.load_scene("earth")
    terrain = scene.planet[pf.Terrain]
    terrain.rivers, terrain.height_map_detail, terrain.height_map = 0.0, 0.0, str(path)
    places = pf.direction(latitude_deg, longitude_deg)
    return pf.TerrainSampler(scene).height(np.atleast_2d(places))


def test_ground_sinks_below_the_sea(folder):
    rng = np.random.default_rng(2)
    latitude, longitude = rng.uniform(46.1, 46.9, 3000), rng.uniform(7.1, 7.9, 3000)
    plain, found = (
        heights_of(folder / "heights", latitude, longitude),
        heights_of(folder / "map.toml", latitude, longitude),
    )
    east_deg = longitude - shore(latitude)
    sea, land, near = east_deg < -0.02, east_deg > 0.03, np.abs(east_deg) < 0.02
    assert np.abs(plain[sea]).max() < 0.01
    np.testing.assert_allclose(found[sea], -6.0, atol=0.01)
    np.testing.assert_allclose(found[land], plain[land], atol=0.01)
    # Along a line across the shore it falls steadily, and crosses the sea's level by it.
    across = np.linspace(-0.02, 0.02, 400)
    line = heights_of(folder / "map.toml", np.full(400, 46.5), shore(46.5) + across)
    assert np.abs(across[np.abs(line).argmin()]) < 0.004 and np.diff(line).min() > -0.2
    assert np.abs(found[near]).max() < 8.0


def test_a_mask_may_be_in_another_system(tmp_path, folder):
    """The same coast in UTM, as tiles of 20 m side by side."""
    pytest.importorskip("pyproj")
    pytest.importorskip("tifffile")
    for a in (0, 1):
        x, y = 3.8e5 + 8000.0 * a, 5.156e6
        longitude, latitude = pixel_places(32632, x, y, 20.0, 500, 400)
        wet = np.where(longitude < shore(latitude), 255, 0).astype(np.uint8)
        write_geotiff(tmp_path / f"sea/{a}.tif", wet, of_code(32632), (x, y, 20.0))
    (tmp_path / "map.toml").write_text(
        f'[[tiles]]\nfolder = "{folder}/heights"\n[[tiles]]\nfolder = "sea"\nkind = "water"\ndepth_m = 6.0\n'
    )
    rng = np.random.default_rng(3)
    latitude, longitude = rng.uniform(46.49, 46.52, 2000), rng.uniform(7.45, 7.6, 2000)
    found = heights_of(tmp_path / "map.toml", latitude, longitude)
    plain = heights_of(folder / "heights", latitude, longitude)
    east_deg = longitude - shore(latitude)
    sea, land = east_deg < -0.035, east_deg > 0.035
    assert sea.sum() > 100 and land.sum() > 100
    np.testing.assert_allclose(found[sea], -6.0, atol=0.01)
    np.testing.assert_allclose(found[land], plain[land], atol=0.01)


def test_a_folder_without_tiles_is_one_warning(tmp_path, folder, caplog):
    (tmp_path / "empty").mkdir()
    (tmp_path / "map.toml").write_text(
        f'[[tiles]]\nfolder = "{folder}/heights"\n[[tiles]]\nfolder = "empty"\nkind = "water"\n'
    )
    with caplog.at_level(logging.WARNING):
        assert np.abs(heights_of(tmp_path / "map.toml", np.array([46.5]), np.array([7.2]))).max() < 0.01
    assert sum("has no tile of water" in record.message for record in caplog.records) == 1


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ('kind = "sea"', ("kind = 'sea'", "'heights' or 'colors' or 'water'")),
        ('kind = "water"\ngeoid_m = 3.0', ("unknown key 'geoid_m'", "kind 'water'", "depth_m")),
        ('kind = "water"\ndepth_m = -1', ("depth_m = -1", "0 to 1000")),
    ],
)
def test_wrong_entries(tmp_path, folder, entry, words):
    (tmp_path / "map.toml").write_text(f'[[tiles]]\nfolder = "{folder}/sea"\n{entry}\n')
    with pytest.raises(pf.SettingError) as caught:
        heights_of(tmp_path / "map.toml", np.array([46.5]), np.array([7.2]))
    for word in words:
        assert word in str(caught.value)
