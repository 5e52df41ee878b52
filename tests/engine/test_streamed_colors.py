"""Pictures of the ground that don't fit into their budget: the same colours, page by page; what is kept and breaks."""

from __future__ import annotations

import gc
import itertools
import logging
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from countries import fields, globe, tile_at, tile_places, write_color_tiff, write_picture
from geotiffs import of_code, pixel_places, write_geotiff

from planetfall.engine.real_ground import streamed_colors as streaming
from planetfall.engine.real_ground.color_reading import forget_colors, make_colors, real_colors
from planetfall.engine.real_ground.color_unlit import Relief
from planetfall.engine.real_ground.lattice import directions_at
from planetfall.engine.real_ground.streamed_color_level import StreamedColorLevel
from planetfall.engine.real_ground.streamed_colors import StreamedColors
from planetfall.engine.wavelengths import DISPLAY_NM

RADIUS_M = 6.371e6
WHOLE, FEW = 256_000_000, 3_000_000
ZOOM, PLACE = 13, (46.5, 7.5)
ACROSS = 5


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache" / "real_ground"


def write_noise(folder, across=ACROSS, holed=False):
    """across x across tiles of fields with noise; in one of them a hole."""
    rng = np.random.default_rng(3)
    x, y = tile_at(ZOOM, *PLACE)
    for j, i in itertools.product(range(across), range(across)):
        at = x + i - across // 2, y + j - across // 2
        pixels = fields(*tile_places(ZOOM, *at)).astype(int)
        pixels = np.clip(pixels + rng.integers(-20, 20, pixels.shape), 0, 255).astype(np.uint8)
        if holed and (j, i) == (1, 3):
            alpha = np.full((256, 256, 1), 255, np.uint8)
            alpha[60:180, 80:200] = 0
            pixels = np.concatenate([pixels, alpha], axis=2)
        write_picture(folder, ZOOM, *at, pixels)
    return folder


@pytest.fixture(scope="module")
def country(tmp_path_factory):
    """Tiles of 19 m, one of which has a hole, on a few of 300 m."""
    folder = write_noise(tmp_path_factory.mktemp("country"), holed=True)
    x, y = tile_at(9, *PLACE)
    for dx, dy in itertools.product((-1, 0, 1), (-1, 0, 1)):
        write_picture(folder, 9, x + dx, y + dy, fields(*tile_places(9, x + dx, y + dy)), "jpg")
    return folder


def places(count, south, north, west, east, seed=1):
    rng = np.random.default_rng(seed)
    return directions_at(rng.uniform(south, north, count), rng.uniform(west, east, count))


BOX = (46.4, 46.6, 7.3, 7.7)


def streamed(folder, most=FEW):
    found = real_colors(str(folder), DISPLAY_NM, most, "Terrain.color_map", streams=True)
    assert isinstance(found, StreamedColors)
    return found


def whole(folder):
    return real_colors(str(folder), DISPLAY_NM, WHOLE, "Terrain.color_map")


def fine_levels(colors):
    return [level for each in colors.sets for level in each.levels if isinstance(level, StreamedColorLevel)]


def equal(few, all_of_it, box, count=500):
    points = places(count, *box)
    for footprint_rad in (1e-9, 3e-6, 1e-5, 1e-4):
        asked = points, np.full(count, footprint_rad)
        for a, b in zip(few.sample(*asked), all_of_it.sample(*asked), strict=True):
            np.testing.assert_array_equal(a, b)


def test_colours_are_those_of_all_tiles_in_memory(country):
    """Bit by bit: in tiles, at borders, in the hole, at all margins, at all footprints."""
    few, all_of_it = streamed(country), whole(country)
    assert len(fine_levels(few)) >= 2 and not fine_levels(all_of_it)
    assert [each.octaves for each in few.sets] == [each.octaves for each in all_of_it.sets]
    for box in (BOX, (44.0, 49.0, 5.0, 10.0), (46.54, 46.56, 7.53, 7.56)):
        equal(few, all_of_it, box)


def test_the_date_line_and_poles_are_the_same(tmp_path):
    pytest.importorskip("tifffile")
    longitude, latitude = np.meshgrid(np.arange(-179.875, 180.0, 0.25), np.arange(89.875, -90.0, -0.25))
    write_color_tiff(tmp_path / "t" / "all.tif", globe(latitude, longitude), -180.0, 90.0, 0.25)
    few, all_of_it = streamed(tmp_path / "t"), whole(tmp_path / "t")
    for box in ((-90.0, 90.0, -180.0, 180.0), (88.0, 90.0, -180.0, 180.0), (10.0, 12.0, 179.5, 180.5)):
        equal(few, all_of_it, box)
    forget_colors()
    equal(streamed(tmp_path / "t"), all_of_it, (85.0, 90.0, -180.0, 180.0))


def test_memory_stays_within_the_budget(country):
    """Whatever is asked for, and however much at once."""
    colors = streamed(country)
    worst = 0
    for seed in range(3):
        colors.sample(places(600, *BOX, seed), np.full(600, 1e-9))
        worst = max(worst, colors.resident_bytes)
    assert colors.pool.loads > 2 * colors.pool.slots  # there was no room for all of it
    assert 0.5 * FEW < worst <= FEW


def test_threads_get_the_same_colours(country):
    few, all_of_it = streamed(country), whole(country)
    asked = [places(100, *BOX, seed) for seed in range(8)]
    footprint = np.full(100, 1e-9)
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda points: few.sample(points, footprint)[0], asked))
    for points, values in zip(asked, found, strict=True):
        np.testing.assert_array_equal(values, all_of_it.sample(points, footprint)[0])


def test_what_fits_is_as_it_was(country, caplog):
    """No page comes and goes, and without streaming sets are read coarser."""
    fits = real_colors(str(country), DISPLAY_NM, WHOLE, "x", streams=True)
    assert fits is whole(country)
    with caplog.at_level(logging.WARNING):
        assert not isinstance(real_colors(str(country), DISPLAY_NM, FEW, "x"), StreamedColors)
    assert "of its resolution" in caplog.text
    caplog.clear()
    with caplog.at_level(logging.WARNING):
        streamed(country)
    assert not caplog.text


def test_without_a_cache_folder_pages_come_from_tiles(country, monkeypatch):
    monkeypatch.setenv("PLANETFALL_CACHE", "")
    equal(streamed(country, FEW + 1), whole(country), BOX, 100)


def test_tiles_are_read_once(tmp_path, monkeypatch):
    """The next start has its index, and pages that were made; a page in memory is not read again."""
    folder = write_noise(tmp_path / "t")
    made, file = make_colors(str(folder), DISPLAY_NM, FEW, "x", streams=True)
    assert isinstance(made, StreamedColors) and file.exists()
    level = fine_levels(made)[0]
    for number in range(0, len(level.where), 5):
        level.page(number, ahead=True)
    points, footprint = places(300, *BOX), np.full(300, 1e-9)
    expected = made.sample(points, footprint)[0]
    forget_colors()
    monkeypatch.setattr(streaming, "read_color_set", lambda *a: pytest.fail("read again"))
    again = streamed(folder)
    assert again is not made
    np.testing.assert_array_equal(again.sample(points, footprint)[0], expected)


def test_files_that_are_damaged_or_gone_are_made_again(tmp_path, cache, caplog):
    folder = write_noise(tmp_path / "t")
    colors = streamed(folder)
    for level in fine_levels(colors):
        for number in range(0, len(level.where), 3):
            level.page(number, ahead=True)
    files = sorted(path for path in cache.rglob("*") if path.is_file() and ".index" not in path.name)
    assert any(path.suffix == ".blocks" for path in files) and sum(path.suffix == ".npz" for path in files) > 4
    for number, path in enumerate(files):
        if number % 3 == 0:
            path.unlink()
        else:
            path.write_bytes(path.read_bytes()[: 100 if number % 3 == 1 else 0])
    forget_colors()
    with caplog.at_level(logging.WARNING):
        equal(streamed(folder), whole(folder), BOX)
    assert "cannot be used and will be written again" in caplog.text
    index = next(cache.glob("*.index.npz"))
    index.write_bytes(index.read_bytes()[:3000])
    forget_colors()
    equal(streamed(folder), whole(folder), BOX)


def test_the_cache_keeps_to_its_limit(tmp_path, cache, monkeypatch):
    """What was used longest ago goes."""
    monkeypatch.setenv("PLANETFALL_CACHE_MB", "3")
    folder = write_noise(tmp_path / "t")
    level = fine_levels(streamed(folder))[0]
    for number in range(0, len(level.where), 3):
        level.page(number, ahead=True)
        assert sum(path.stat().st_size for path in cache.rglob("*") if path.is_file()) < 4.0e6
    equal(streamed(folder), whole(folder), BOX)


@pytest.mark.parametrize("kind", ["gone", "cut off"])
def test_a_tile_that_breaks_while_pages_come(tmp_path, caplog, kind):
    """One warning; coarser pixels stand in its middle, the other tiles as before, and nothing of it is kept."""
    folder = write_noise(tmp_path / "t")
    colors, all_of_it = streamed(folder), whole(folder)
    x, y = tile_at(ZOOM, *PLACE)
    file = folder / f"{ZOOM}/{x}/{y}.png"
    data = file.read_bytes()
    file.unlink() if kind == "gone" else file.write_bytes(data[:5000])
    latitude, longitude = tile_places(ZOOM, x, y)
    there = directions_at(latitude[100:150:9, 100:150:9].ravel(), longitude[100:150:9, 100:150:9].ravel())
    latitude, longitude = tile_places(ZOOM, x + 2, y + 2)
    other = directions_at(latitude[90:200:9, 90:200:9].ravel(), longitude[90:200:9, 90:200:9].ravel())
    with caplog.at_level(logging.WARNING):
        _, weight = colors.sample(there, np.full(there.shape[1], 1e-9))
        asked = other, np.full(other.shape[1], 1e-9)
        np.testing.assert_array_equal(colors.sample(*asked)[0], all_of_it.sample(*asked)[0])
    assert sum(str(file) in r.getMessage() for r in caplog.records) == 1
    assert weight.max() < 1.0
    level = fine_levels(colors)[0]
    for number in range(len(level.where)):
        level.page(number, ahead=True)
    file.write_bytes(data)
    forget_colors()
    equal(streamed(folder), all_of_it, BOX)


def test_the_sun_goes_out_by_ground_that_nothing_names(tmp_path, cache):
    """What was made is kept as long as the map is: in a folder that goes with it."""
    folder = write_noise(tmp_path / "t")

    def hills(directions):
        latitude, longitude = np.degrees(np.arcsin(directions[2])), np.degrees(np.arctan2(*directions[1::-1]))
        return 1000.0 + 80.0 * np.sin(300.0 * latitude) * np.sin(260.0 * longitude)

    relief = Relief(hills, 60.0, RADIUS_M, "hills")
    few, all_of_it = (
        real_colors(str(folder), DISPLAY_NM, most, "x", 1.0, relief, streams=True) for most in (FEW, WHOLE)
    )
    assert isinstance(few, StreamedColors) and few.index is None and not list(cache.rglob("*.npz"))
    passing = fine_levels(few)[0].source.files.folder
    fine_levels(few)[0].page(30, ahead=True)
    assert passing is not None and any(passing.iterdir())
    equal(few, all_of_it, BOX)
    forget_colors()
    del few
    gc.collect()
    assert not passing.exists()


def test_a_survey_in_another_system_is_the_same(tmp_path):
    """UTM, interpolated window by window."""
    pytest.importorskip("tifffile")
    pytest.importorskip("pyproj")
    place = (380_000.0, 5_160_000.0, 20.0)
    longitude, latitude = pixel_places(32632, *place, 1200, 1200)
    write_geotiff(tmp_path / "t" / "utm.tif", fields(latitude, longitude), of_code(32632), place)
    few, all_of_it = streamed(tmp_path / "t", 2_000_000), whole(tmp_path / "t")
    equal(few, all_of_it, (latitude.min(), latitude.max(), longitude.min(), longitude.max()))
