"""Tiles of pictures of the ground: files, gaps, margins, sets over one another, memory."""

from __future__ import annotations

import logging

import numpy as np
import pytest
from countries import fields, globe, tile_at, tile_places, write_color_tiff, write_fields, write_picture
from geotiffs import of_code, pixel_places, write_geotiff
from PIL import Image

from planetfall.engine.display import reflectance
from planetfall.engine.real_ground.color_margins import MARGIN
from planetfall.engine.real_ground.color_reading import real_colors
from planetfall.engine.real_ground.lattice import directions_at
from planetfall.engine.real_ground.tile_files import TileError
from planetfall.engine.srgb import srgb_decode
from planetfall.engine.wavelengths import DISPLAY_NM

PLACE = (46.5, 7.5)
WHAT = "Terrain.color_map"


def colors_of(path, most_bytes=256_000_000):
    return real_colors(str(path), DISPLAY_NM, most_bytes, WHAT)


def seen(found, latitude_deg, longitude_deg, footprint_rad=1e-9):
    """Colours (N, 3) and weights (N,)."""
    latitude, longitude = (np.ravel(v) for v in np.broadcast_arrays(latitude_deg, longitude_deg))
    values, weight = found.sample(directions_at(latitude, longitude), np.full(latitude.size, footprint_rad))
    return values.T / np.maximum(weight, 1e-9)[:, None], weight


def exact(pixels):
    return reflectance(srgb_decode(np.asarray(pixels, float) / 255.0), DISPLAY_NM)


def off_steps(found, expected):
    """Largest difference, in steps of a texture's 8 bits."""
    return 255.0 * np.abs(np.sqrt(found) - np.sqrt(expected.reshape(-1, 3))).max()


@pytest.mark.parametrize(("ending", "steps"), [("png", 1.0), ("jpg", 25.0)])
def test_pixels_are_the_files(tmp_path, ending, steps):
    write_fields(tmp_path, 12, *PLACE, 2, ending)
    found = colors_of(tmp_path)
    x, y = tile_at(12, *PLACE)
    for tile in ((x, y), (x - 1, y - 1)):
        places = tile_places(12, *tile)
        color, weight = seen(found, *places)
        assert (weight == 1.0).all() and off_steps(color, exact(fields(*places))) < steps


def test_tiles_meet_without_a_seam(tmp_path):
    """Half way between the last pixel of a tile and the first of the next one is their mean."""
    write_fields(tmp_path, 12, *PLACE, 2)
    found = colors_of(tmp_path)
    x, y = tile_at(12, *PLACE)
    latitude, longitude = tile_places(12, x, y)
    west = tile_places(12, x - 1, y)[1][:, -1]
    middle = 0.5 * (west + longitude[:, 0])
    color, _ = seen(found, latitude[:, 0], middle)
    both = 0.5 * (exact(fields(latitude[:, 0], west)) + exact(fields(latitude[:, 0], longitude[:, 0])))
    assert off_steps(color, both) < 1.0


@pytest.mark.parametrize("planar", [False, True])
@pytest.mark.parametrize("bits", [8, 16])
def test_geotiffs(tmp_path, planar, bits):
    pytest.importorskip("tifffile")
    longitude, latitude = np.meshgrid(7.0 + (np.arange(40) + 0.5) * 0.01, 47.0 - (np.arange(30) + 0.5) * 0.01)
    pixels = globe(latitude * 30.0, longitude * 30.0)
    pixels[10:14, 20:24] = 0
    values = pixels.astype(np.uint16) * 257 if bits == 16 else pixels
    tags = [(42113, "s", 0, "0", True)]
    words = {"planarconfig": "separate"} if planar else {}
    values = np.moveaxis(values, -1, 0) if planar else values
    write_color_tiff(tmp_path / "a.tif", values, 7.0, 47.0, 0.01, tags=tags, **words)
    color, weight = seen(colors_of(tmp_path), latitude, longitude)
    hole = np.zeros((30, 40), bool)
    hole[10:14, 20:24] = True
    assert off_steps(color[~hole.ravel()], exact(pixels[~hole])) < 1.0 and (weight[~hole.ravel()] == 1.0).all()
    assert (weight[hole.ravel()] > 0.9).all() and color[hole.ravel()].min() > 1e-3  # closed by what is around


@pytest.mark.parametrize("planar", [False, True])
def test_geotiffs_in_other_systems(tmp_path, planar):
    """Two pictures of LV95 side by side: at pixels their colours are the file's, to what a curve through them leaves,
    also where both meet; gaps are gaps."""
    pytest.importorskip("pyproj")
    pytest.importorskip("tifffile")
    places, every = [], []
    for a in (0, 1):
        x, y = 2.6e6 + 1500.0 * a, 1.2e6
        longitude, latitude = pixel_places(2056, x, y, 10.0, 140, 150)
        pixels = globe(latitude * 30.0, longitude * 30.0)
        pixels[60:90, 60:90] = 0
        values, words = (np.moveaxis(pixels, -1, 0), {"planarconfig": "separate"}) if planar else (pixels, {})
        tags = ((42113, "s", 0, "0", True),)
        write_geotiff(tmp_path / f"{a}.tif", values, of_code(2056), (x, y, 10.0), tags=tags, **words)
        places.append((latitude, longitude))
        every.append(pixels)
    latitude, longitude, pixels = (np.concatenate(v, axis=1) for v in (*zip(*places, strict=True), every))
    inner = np.zeros(latitude.shape, bool)
    inner[2:-2, 2:-2] = True
    for left in (60, 210):
        inner[58:92, left - 2 : left + 32] = False
    found = colors_of(tmp_path)
    color, weight = seen(found, latitude[inner], longitude[inner])
    assert (weight == 1.0).all() and off_steps(color, exact(pixels[inner])) < 3.0
    color, weight = seen(found, latitude[75, 75], longitude[75, 75])
    assert 0.5 < weight[0] <= 1.0 and color.min() > 1e-3  # closed by what is around


def test_a_picture_fades_over_its_margin(tmp_path):
    """Transparent pixels are gaps, whose colours are those of the border and whose weight falls over the margin."""
    x, y = tile_at(12, *PLACE)
    latitude, longitude = tile_places(12, x, y)
    pixels = np.full((256, 256, 4), (90, 120, 60, 255), np.uint8)
    pixels[:, 128:] = 0
    write_picture(tmp_path, 12, x, y, pixels)
    color, weight = seen(colors_of(tmp_path), latitude[100], longitude[100])
    beyond = weight[128:]
    assert (weight[:128] == 1.0).all() and (np.diff(beyond) <= 0.0).all()
    assert beyond[0] > 0.98 and 0.4 < beyond[MARGIN // 2] < 0.6 and (beyond[MARGIN:] == 0.0).all()
    assert off_steps(color[128 : 128 + MARGIN - 4], exact([[90, 120, 60]])) < 12.0  # weights are of 8 bits


def test_sets_lie_over_one_another(tmp_path):
    write_fields(tmp_path / "coarse", 10, *PLACE, 2)
    x, y = tile_at(13, *PLACE)
    write_picture(tmp_path / "fine", 13, x, y, np.full((256, 256, 3), 200, np.uint8))
    (tmp_path / "map.toml").write_text('[[tiles]]\nfolder = "coarse"\n[[tiles]]\nfolder = "fine"\nkind = "colors"\n')
    found = colors_of(tmp_path / "map.toml")
    assert len(found.sets) == 2
    latitude, longitude = tile_places(13, x, y)
    color, weight = seen(found, latitude, longitude)
    assert off_steps(color, exact(np.full((256, 256, 3), 200))) < 1.0 and (weight == 1.0).all()
    step = longitude[0, 1] - longitude[0, 0]
    line, weight = seen(found, latitude[128, 0], longitude[0, 255] + step * np.arange(0.0, 2.0 * MARGIN, 0.25))
    assert (weight == 1.0).all() and np.abs(np.diff(np.sqrt(line), axis=0)).max() < 0.02  # no border shows


def test_footprints_show_means(tmp_path):
    """Of stripes a pixel wide a footprint of many pixels sees their mean light, and nothing of them."""
    x, y = tile_at(12, *PLACE)
    stripes = np.zeros((256, 256, 3), np.uint8)
    stripes[:, ::2] = 200
    for dx in (-1, 0, 1):
        for dy in (-1, 0, 1):
            write_picture(tmp_path, 12, x + dx, y + dy, stripes)
    found = colors_of(tmp_path)
    pixel_rad = 2.0 * np.pi / (256 << 12) * np.cos(np.radians(PLACE[0]))
    latitude, longitude = (v[100:140, 100:140] for v in tile_places(12, x, y))
    mean = 0.5 * exact([[200, 200, 200]])
    for pixels, most in ((1.0, 200.0), (2.0, 2.0), (3.0, 2.0), (16.0, 2.0)):
        color, _ = seen(found, latitude, longitude, pixels * pixel_rad)
        assert off_steps(color, np.broadcast_to(mean, color.shape)) < most
    assert np.ptp(seen(found, latitude, longitude, pixel_rad)[0]) > 0.4


def test_memory_is_kept_to(tmp_path, caplog):
    write_fields(tmp_path, 14, *PLACE, 6)
    with caplog.at_level(logging.WARNING):
        found = colors_of(tmp_path, 3_000_000)
    assert "1/2 of its resolution" in caplog.text or "1/4 of its resolution" in caplog.text
    assert "Terrain.color_map_most_mb = 3; raise it" in caplog.text
    assert sum(level.pixels.nbytes for level in found.sets[0].levels) < 4_000_000
    x, y = tile_at(14, *PLACE)
    latitude, longitude = tile_places(14, x, y)
    color, weight = seen(found, latitude, longitude)
    assert (weight == 1.0).all() and off_steps(color, exact(fields(latitude, longitude))) < 40.0


def test_a_broken_tile_is_one_warning(tmp_path, caplog):
    write_fields(tmp_path, 13, *PLACE, 2)
    x, y = tile_at(13, *PLACE)
    broken = tmp_path / "13" / str(x) / f"{y}.png"
    broken.write_bytes(broken.read_bytes()[:2000])
    with caplog.at_level(logging.WARNING):
        found = colors_of(tmp_path)
    assert sum(str(broken) in record.message for record in caplog.records) == 1
    latitude, longitude = tile_places(13, x, y)
    assert seen(found, latitude[128, 128], longitude[128, 128])[1] == 0.0
    assert seen(found, latitude[0, 0] + 0.01, longitude[128, 128])[1] == 1.0


def _bad(folder, pixels, **words):
    write_color_tiff(folder / "a.tif", pixels, 7.0, 47.0, 0.01, **words)


@pytest.mark.parametrize(
    ("write", "words"),
    [
        (lambda folder: None, ("no tile of a picture", "zoom/x/y")),
        (lambda folder: _bad(folder, np.zeros((4, 4, 3), np.float32)), ("float32", "-ot Byte")),
        (
            lambda folder: _bad(folder, np.zeros((8, 9, 6), np.uint8), planarconfig="contig"),
            ("6 channels", "gdal_translate -b 1"),
        ),
        (lambda folder: Image.new("RGB", (8, 8)).save(folder / "a.png"), ("no tile by zoom/x/y", "rename it")),
    ],
)
def test_what_is_no_picture_says_so(tmp_path, caplog, write, words):
    pytest.importorskip("tifffile")
    (tmp_path / "tiles").mkdir()
    write(tmp_path / "tiles")
    with caplog.at_level(logging.WARNING), pytest.raises(TileError) as caught:
        colors_of(tmp_path / "tiles")
    for word in words:
        assert word in caplog.text + str(caught.value)


def test_one_sun_is_two_numbers(tmp_path):
    (tmp_path / "map.toml").write_text("[[tiles]]\nsun_azimuth_deg = 140.0\n")
    with pytest.raises(TileError, match="sun_azimuth_deg and sun_elevation_deg, or neither"):
        colors_of(tmp_path / "map.toml")
