"""Real elevation: heights at samples and between them, seams, poles, holes, sets over one another, levels kept."""

from __future__ import annotations

import gc
import itertools
import logging
import struct
import weakref
import zlib
from pathlib import Path

import numpy as np
import pytest
from countries import hgt_samples, land, write_country, write_hgt, write_png_tile

from planetfall.engine.real_ground import resident
from planetfall.engine.real_ground.lattice import directions_at
from planetfall.engine.real_ground.limited_cubic import OVERSHOOT, limited_cubic, limited_slope
from planetfall.engine.real_ground.resident import make_ground, real_ground, resident_ground
from planetfall.engine.real_ground.tile_files import TileError
from planetfall.engine.real_ground.tile_index import open_tiles

RADIUS_M = 6.371e6
MOST = 64_000_000


def ground_of(folder, most=MOST):
    return real_ground(str(folder), most, "Terrain.height_map")


def at(ground, latitude, longitude):
    """(heights, rest) at places of any shape."""
    latitude, longitude = np.broadcast_arrays(np.asarray(latitude, float), np.asarray(longitude, float))
    height, rest = ground.heights(directions_at(latitude.ravel(), longitude.ravel()))
    return height.reshape(latitude.shape), rest.reshape(latitude.shape)


def write_tiff(file, values, west, north, step_x, step_y, point=False, model=2, code=4326):
    """A GeoTIFF whose first pixel's corner, or middle for `point`, is at (west, north)."""
    tifffile = pytest.importorskip("tifffile")
    keys = (1, 1, 0, 3, 1024, 0, 1, model, 1025, 0, 1, 2 if point else 1, 2048 if model == 2 else 3072, 0, 1, code)
    tags = [
        (33550, "d", 3, (step_x, step_y, 0.0), True),
        (33922, "d", 6, (0.0, 0.0, 0.0, west, north, 0.0), True),
        (34735, "H", len(keys), keys, True),
    ]
    file.parent.mkdir(parents=True, exist_ok=True)
    tifffile.imwrite(file, values, extratags=tags)


@pytest.fixture(scope="module")
def country(tmp_path_factory):
    return ground_of(write_country(tmp_path_factory.mktemp("country")))


# -- the cubic ---------------------------------------------------------------------------------------------------------


def test_the_limiter_keeps_its_bounds():
    """Those that limited_cubic.py derives its overshoot from."""
    ratio = np.geomspace(1e-6, 1e6, 4001)
    one = np.ones_like(ratio)
    assert (limited_slope(one, ratio) / np.minimum(one, ratio)).max() < 2.1
    assert (np.abs(limited_slope(one, -ratio)) / np.maximum(one, ratio)).max() < 0.296
    t = np.linspace(0.0, 1.0, 2001)
    for m0 in np.linspace(-0.296, 2.1, 30):
        for m1 in np.linspace(-0.296, 2.1, 30):
            f = t * t * (3.0 - 2.0 * t) + m0 * t * (1.0 - t) ** 2 - m1 * t * t * (1.0 - t)
            assert f.min() > -0.0149 and f.max() < 1.0149
    assert OVERSHOOT > 0.0149 + 0.0149 * (1.0 + 2.0 * 0.0149)


def test_even_steps_are_catmull_roms():
    taps, t = np.array([[0.0], [1.0], [2.02], [3.06]]), np.array([0.37])
    w = np.array([-0.5 * t + t * t - 0.5 * t**3, 1.0 - 2.5 * t * t + 1.5 * t**3, 0.5 * t + 2.0 * t * t - 1.5 * t**3,
                  -0.5 * t * t + 0.5 * t**3])  # fmt: skip
    assert abs(limited_cubic(taps, t)[0][0] - (w * taps).sum()) < 1e-6


@pytest.mark.parametrize("kind", ["noise", "steps", "spikes"])
def test_no_overshoot_between_samples(tmp_path, kind):
    """Heights stay within the range of a cell's four corners, and 5 % of it, however wild samples are."""
    rng = np.random.default_rng(1)
    values = {
        "noise": rng.normal(1000.0, 300.0, (61, 61)),
        "steps": np.where(rng.random((61, 61)) < 0.5, 0.0, 2000.0),
        "spikes": np.where(rng.random((61, 61)) < 0.05, 4000.0, 10.0),
    }[kind]
    samples = np.rint(values).astype(np.int16)
    write_hgt(tmp_path, 46, 7, 61, samples)
    ground = ground_of(tmp_path)
    cell = rng.integers(0, 60, (2, 20000))
    f = rng.random((2, 20000))
    height, _ = at(ground, 47.0 - (cell[0] + f[0]) / 60.0, 7.0 + (cell[1] + f[1]) / 60.0)
    corners = np.stack([samples[cell[0] + b, cell[1] + a] for a in (0, 1) for b in (0, 1)]).astype(float)
    low, high = corners.min(axis=0), corners.max(axis=0)
    room = OVERSHOOT * (high - low) + 1e-6
    assert (height >= low - room).all() and (height <= high + room).all()


# -- files -------------------------------------------------------------------------------------------------------------


def test_heights_at_samples_are_the_files(country):
    step = np.arange(31) / 30.0
    for south, west in ((40, 0), (44, 7), (49, 19)):  # at a corner of the country, too
        found, rest = at(country, (south + 1.0 - step)[:, None], west + step)
        assert np.abs(found - hgt_samples(south, west, 31)).max() < 1e-3
        assert not rest.any()


@pytest.mark.parametrize("point", [False, True], ids=["areas", "points"])
def test_geotiffs_in_degrees(tmp_path, point):
    values = np.random.default_rng(2).normal(800.0, 50.0, (40, 50)).astype(np.float32)
    write_tiff(tmp_path / "a.tif", values, 7.5, 46.25, 0.01, 0.01, point)
    first = 0.0 if point else 0.005
    found, rest = at(ground_of(tmp_path), (46.25 - first - 0.01 * np.arange(40))[:, None],
                     7.5 + first + 0.01 * np.arange(50))  # fmt: skip
    assert np.abs(found - values).max() < 1e-3 and not rest.any()


def test_geotiffs_of_mercator(tmp_path):
    """EPSG:3857, 100 m of its metres apart."""
    values = np.random.default_rng(2).normal(800.0, 50.0, (30, 40)).astype(np.float32)
    x, y, radius = 890000.0, 5860000.0, 6378137.0
    write_tiff(tmp_path / "a.tif", values, x, y, 100.0, 100.0, False, model=1, code=3857)
    rows, columns = y - 100.0 * (np.arange(30) + 0.5), x + 100.0 * (np.arange(40) + 0.5)
    latitude = np.degrees(np.arctan(np.sinh(rows / radius)))
    found, _ = at(ground_of(tmp_path), latitude[:, None], np.degrees(columns / radius))
    assert np.abs(found - values).max() < 1e-3


@pytest.mark.parametrize("size", [64, 256])
def test_png_tiles_by_zoom(tmp_path, size):
    for x, y in ((8, 5), (9, 5), (8, 6)):
        write_png_tile(tmp_path, 4, x, y, size)
    rows, columns = np.arange(5 * size, 6 * size), np.arange(8 * size, 10 * size)
    v, u = (rows + 0.5) / (16 * size), (columns + 0.5) / (16 * size)
    latitude, longitude = np.degrees(np.arctan(np.sinh(np.pi * (1.0 - 2.0 * v))))[:, None], 360.0 * u - 180.0
    found, rest = at(ground_of(tmp_path), latitude, longitude)
    assert np.abs(found - land(latitude, longitude)).max() < 0.0501 and not rest.any()


def test_one_sample_is_a_tile(tmp_path):
    write_tiff(tmp_path / "one.tif", np.full((1, 1), 1234.5, np.float32), 7.0, 46.0, 0.01, 0.01)
    found, rest = at(ground_of(tmp_path), 45.995, 7.005)
    assert abs(found - 1234.5) < 1e-3 and rest == 0.0


def test_an_index_file_adds_the_geoid(tmp_path):
    write_hgt(tmp_path / "a", 46, 7, 31)
    (tmp_path / "map.toml").write_text('[[tiles]]\nfolder = "a"\ngeoid_m = 47.25\n', encoding="utf-8")
    found, _ = at(ground_of(tmp_path / "map.toml"), 46.5, 7.5)
    assert abs(found - (hgt_samples(46, 7, 31)[15, 15] + 47.25)) < 1e-3


# -- seams -------------------------------------------------------------------------------------------------------------


def test_borders_of_tiles_do_not_show(country):
    """Along walks across borders heights differ from the field as they do elsewhere, and nothing jumps."""
    along = np.linspace(-1e-4, 1e-4, 2001)
    for latitude, longitude in ((45.37 + 0.0 * along, 7.0 + along), (45.0 + along, 7.41 + 0.0 * along),
                                (45.0 + along, 7.0 + along)):  # fmt: skip
        height, _ = at(country, latitude, longitude)
        length_m = np.radians(1e-7) * RADIUS_M * 1.5
        assert np.abs(np.diff(height)).max() < 0.2 * length_m
    rng = np.random.default_rng(3)
    latitude, longitude = rng.uniform(40.0, 50.0, 20000), rng.uniform(0.0, 20.0, 20000)
    height, _ = at(country, latitude, longitude)
    assert np.abs(height - land(latitude, longitude)).max() < 5.0  # hills of 0.4 degrees, samples of 1/30


def test_the_date_line_does_not_show(tmp_path):
    ground = ground_of(write_country(tmp_path, 10, 177, 3, 6))
    step = np.arange(31) / 30.0
    for west in (179, -180):
        found, rest = at(ground, (12.0 - step)[:, None], west + step)
        assert np.abs(found - hgt_samples(11, west, 31)).max() < 1e-3 and not rest.any()
    along = np.linspace(-1e-4, 1e-4, 2001)
    for start in (180.0, -180.0):
        height, _ = at(ground, np.full(2001, 11.4), start + along)
        assert np.abs(np.diff(height)).max() < 0.2 * np.radians(1e-7) * RADIUS_M * 1.5
    assert np.ptp(at(ground, 11.4, np.array([-180.0, 180.0]))[0]) < 1e-6


def test_poles_do_not_show(tmp_path):
    """All of a planet, pixels of 2 degrees: samples are the file's, and at a pole all meridians meet."""
    latitude, longitude = (89.0 - 2.0 * np.arange(90))[:, None], -179.0 + 2.0 * np.arange(180)
    values = land(latitude, longitude).astype(np.float32)
    write_tiff(tmp_path / "all.tif", values, -180.0, 90.0, 2.0, 2.0)
    ground = ground_of(tmp_path)
    found, rest = at(ground, latitude, longitude)
    assert np.abs(found - values).max() < 1e-3 and not rest.any()
    for sign in (1.0, -1.0):
        turn = np.linspace(-180.0, 180.0, 721)
        for away, most in ((1e-7, 1e-3), (0.01, 2.0)):
            height, rest = at(ground, np.full(721, sign * (90.0 - away)), turn)
            assert np.ptp(height) < most and not rest.any()


# -- gaps --------------------------------------------------------------------------------------------------------------


def test_holes_show_the_next_coarser_set(tmp_path):
    """A hole wider than what a level bridges: the coarse set stands there, and both pass into one another."""
    fine = hgt_samples(46, 7, 601)
    fine[100:400, 150:450] = -32768
    write_hgt(tmp_path / "fine", 46, 7, 601, fine)
    write_country(tmp_path / "coarse", 45, 6, 3, 3, 61)
    ground = ground_of(tmp_path)
    middle = at(ground, 47.0 - 250.0 / 600.0, 7.0 + 300.0 / 600.0)[0]
    assert abs(middle - land(47.0 - 250.0 / 600.0, 7.5)) < 5.0
    step = np.arange(601) / 600.0
    found, rest = at(ground, (47.0 - step)[:, None], 7.0 + step)
    there = fine != -32768
    assert np.abs(found - fine)[there].max() < 1e-3 and not rest.any()
    # No cliff: nothing is steeper than the field, but for the fine set's whole metres.
    steep = np.abs(np.diff(found, axis=1)).max() / (np.radians(1.0 / 600.0) * RADIUS_M * 0.69)
    field = np.abs(np.diff(land((47.0 - step)[:, None], 7.0 + step), axis=1)).max()
    assert steep < field / (np.radians(1.0 / 600.0) * RADIUS_M * 0.69) + 0.02


def test_borders_are_no_cliffs(country):
    """2 km above the ground around: the way down is as wide as the coarsest level's margin."""
    longitude = np.linspace(-12.0, 5.0, 40001)
    height, rest = at(country, np.full(40001, 45.2), longitude)
    total = height - 3000.0 * rest
    assert rest[0] == 1.0 and rest[-1] == 0.0
    length_m = np.radians(17.0 / 40000.0) * RADIUS_M * np.cos(np.radians(45.2))
    assert np.abs(np.diff(total)).max() / length_m < 0.12


def test_finer_sets_lie_over_coarser_ones(tmp_path):
    """Each at its own samples; around the finer one both pass into one another within eight of its samples."""
    write_country(tmp_path / "coarse", 45, 6, 3, 3, 31)
    values = (hgt_samples(46, 7, 301) + 25).astype(np.int16)
    write_hgt(tmp_path / "fine", 46, 7, 301, values)
    ground = ground_of(tmp_path)
    step = np.arange(301) / 300.0
    assert np.abs(at(ground, (47.0 - step)[:, None], 7.0 + step)[0] - values).max() < 1e-3
    far = np.arange(10, 31) / 30.0
    found, _ = at(ground, 47.0 + far, np.full(21, 7.5))
    assert np.abs(found - hgt_samples(47, 7, 31)[30 - np.arange(10, 31), 15]).max() < 0.6


def test_broken_tiles_cost_one_warning_each(tmp_path, caplog):
    write_hgt(tmp_path, 46, 7, 31)
    whole = write_hgt(tmp_path, 46, 8, 31)
    whole.write_bytes(whole.read_bytes()[:1000])
    (tmp_path / "notes.hgt").write_bytes(b"\0" * 1922)
    write_png_tile(tmp_path, 9, 266, 181, 64).write_bytes(b"no picture")
    huge = b"IHDR" + struct.pack(">IIBBBBB", 30000, 30000, 8, 2, 0, 0, 0)  # which Pillow takes for a bomb
    header = b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + huge + struct.pack(">I", zlib.crc32(huge))
    write_png_tile(tmp_path, 9, 266, 182, 64).write_bytes(header + struct.pack(">I", 0) + b"IDAT" + b"\0" * 64)
    with caplog.at_level(logging.WARNING):
        ground = ground_of(tmp_path)
    said = [r.getMessage() for r in caplog.records if "left out" in r.getMessage()]
    assert len(said) == 4 and all("Terrain.height_map" in text for text in said)
    for word in (
        "N46E008.hgt has 1000 bytes",
        "notes.hgt has no place in its name",
        "181.png can't be read",
        "182.png can't be read",
    ):
        assert any(word in text for text in said), said
    assert at(ground, 46.5, 7.5)[1] == 0.0


def test_a_tile_that_breaks_later_is_left_out(tmp_path, caplog):
    """Its header is fine, its pixels are not."""
    write_hgt(tmp_path, 46, 7, 31)
    file = write_png_tile(tmp_path, 9, 266, 181, 64)
    file.write_bytes(file.read_bytes()[:600])
    with caplog.at_level(logging.WARNING):
        ground_of(tmp_path)
    assert sum("181.png can't be read" in r.getMessage() for r in caplog.records) == 1


BAD = {
    "nothing there": (lambda f: None, ("no tile of elevation", "N46E007.hgt")),
    "all broken": (lambda f: (f / "N46E007.hgt").write_bytes(b"abc"), ("no tile of elevation",)),
    "an index of nothing": (lambda f: (f / "map.toml").write_text("x = 1\n"), ("[[tiles]]", "'x'")),
    "no toml": (lambda f: (f / "map.toml").write_text("[[tiles"), ("can't be read", "correct the file")),
    "unknown key": (lambda f: (f / "map.toml").write_text("[[tiles]]\nfile = 'a'\n"), ("unknown key 'file'", "folder")),
    "wrong kind": (lambda f: (f / "map.toml").write_text("[[tiles]]\ngeoid_m = 'a'\n"), ("geoid_m", "a number")),
    "unknown code": (lambda f: (f / "map.toml").write_text("[[tiles]]\npng = 'grey'\n"), ("'grey'", "terrarium")),
    "no table": (lambda f: (f / "map.toml").write_text("tiles = ['a']\n"), ("found 'a'", "[[tiles]]")),
    "no height": (lambda f: (f / "map.toml").write_text("[[tiles]]\ngeoid_m = nan\n"), ("geoid_m = nan", "metres")),
    "a list of kinds": (lambda f: (f / "map.toml").write_text("[[tiles]]\nkind = ['heights']\n"),
                        ("kind = ['heights']", "'colors'")),
    "a table of kinds": (lambda f: (f / "map.toml").write_text("[[tiles]]\nkind = {a = 1}\n"),
                         ("kind = {'a': 1}", "'colors'")),
    "huge number": (lambda f: (f / "map.toml").write_text(f"[[tiles]]\ngeoid_m = {'9' * 5000}\n"), ("can't be read",)),
    "deep": (lambda f: (f / "map.toml").write_text(f"tiles = {'[' * 5000}"), ("brackets", "correct the file")),
    "no name": (lambda f: (f / "map.toml").write_text('[[tiles]]\nfolder = "a\\u0000b"\n'), ("no folder", "correct")),
    "long name": (lambda f: (f / "map.toml").write_text(f"[[tiles]]\nfolder = '{'x' * 300}'\n"), ("no folder",)),
    "no folder": (lambda f: (f / "map.toml").write_text("[[tiles]]\nfolder = 'x'\n"), ("no folder", "correct")),
}  # fmt: skip


@pytest.mark.parametrize("what", sorted(BAD))
def test_bad_maps_say_what_to_do(tmp_path, what):
    make, words = BAD[what]
    make(tmp_path)
    file = tmp_path / "map.toml"
    with pytest.raises(TileError) as caught:
        ground_of(file if file.exists() else tmp_path)
    for word in ("Terrain.height_map", *words):
        assert word in str(caught.value), str(caught.value)


@pytest.mark.parametrize("path", ["~nobody of that name/a.toml", "a\0b.toml", "x" * 300, "x" * 300 + ".toml"])
def test_paths_to_nothing_say_so(path):
    """Of other users who aren't there, with a zero in them, and too long for a file."""
    with pytest.raises(TileError, match=r"^Terrain\.height_map: .*(correct the file|neither a folder of tiles)"):
        ground_of(path)


def test_names_may_have_any_character(tmp_path):
    """Line breaks and bytes that are no text, when all is looked at and when it is known."""
    write_hgt(tmp_path, 46, 7, 31).rename(tmp_path / "N46E007\n2.hgt")
    write_hgt(tmp_path, 46, 8, 31).rename(tmp_path / "\n\udcff N46E008.hgt")
    (tmp_path / "no\nplace.hgt").write_bytes(b"\0" * 1922)
    for again in range(3):
        if again == 2:  # some are known, and one is not
            write_hgt(tmp_path, 46, 9, 31)
        (found,) = open_tiles(str(tmp_path), "Terrain.height_map")
        assert sorted(found.names)[:2] == ["\n\udcff N46E008.hgt", "N46E007\n2.hgt"] and len(found) == 2 + (again == 2)
        height, rest = at(ground_of(tmp_path), 46.5, [7.5, 8.5])
        assert not rest.any() and abs(height[0] - hgt_samples(46, 7, 31)[15, 15]) < 1e-3


MISPLACED = {
    "beyond a pole": (dict(west=7.0, north=95.0, step_x=0.1, step_y=0.1), "latitudes 94.95 to 94.95"),
    "metres as degrees": (dict(west=4e5, north=5e6, step_x=30.0, step_y=30.0), "expected -90 to 90"),
    "no step": (dict(west=7.0, north=47.0, step_x=0.0, step_y=0.1), "pixels are 0 x 0.1"),
    "south on top": (dict(west=7.0, north=47.0, step_x=0.1, step_y=-0.1), "rows from north to south"),
    "no number": (dict(west=float("nan"), north=47.0, step_x=0.1, step_y=0.1), "at (nan, 47)"),
}


@pytest.mark.parametrize("what", sorted(MISPLACED))
def test_tiles_off_the_map_are_left_out(tmp_path, what, caplog):
    place, words = MISPLACED[what]
    write_hgt(tmp_path, 46, 7, 31)
    write_tiff(tmp_path / "off.tif", np.zeros((1, 1), np.float32), **place)
    with caplog.at_level(logging.WARNING):
        ground = ground_of(tmp_path)
    assert words in caplog.text and "left out" in caplog.text
    assert at(ground, 46.5, 7.5)[1] == 0.0


def test_links_may_lead_nowhere_or_back(tmp_path, caplog):
    write_hgt(tmp_path, 46, 7, 31)
    (tmp_path / "N46E008.hgt").symlink_to(tmp_path / "gone.hgt")
    (tmp_path / "again").symlink_to(tmp_path)
    (tmp_path / "N46E009.hgt").mkdir()
    with caplog.at_level(logging.WARNING):
        (found,) = open_tiles(str(tmp_path), "Terrain.height_map")
    assert found.names == ["N46E007.hgt"]
    assert sum("left out" in r.getMessage() for r in caplog.records) == 1 and "N46E008.hgt has 0 bytes" in caplog.text


def test_a_tile_that_is_renamed_moves(tmp_path):
    """As messages say: time and size stay, the place doesn't."""
    file = write_hgt(tmp_path, 46, 7, 31)
    write_hgt(tmp_path, 50, 7, 31)
    assert at(ground_of(tmp_path), 46.5, 8.5)[1] > 0.0
    file.rename(tmp_path / "N46E008.hgt")
    assert at(ground_of(tmp_path), 46.5, 8.5)[1] == 0.0


def test_maps_are_read_once_while_they_are_in_use(tmp_path, monkeypatch):
    """However many there are; and not kept afterwards, but for the last one."""
    folders = [tmp_path / str(k) for k in range(4)]
    for k, folder in enumerate(folders):
        write_hgt(folder, 40 + k, 7, 11)
    held = [ground_of(folder) for folder in folders]
    assert all(ground_of(folder) is ground for folder, ground in zip(folders, held, strict=True))
    gone = [weakref.ref(ground) for ground in held]
    ground_of(folders[0])
    held.clear()
    gc.collect()
    assert [ref() is not None for ref in gone] == [True, False, False, False]


# -- gradients, memory, what is kept -----------------------------------------------------------------------------------


def test_gradients_are_those_of_the_heights(country):
    rng = np.random.default_rng(5)
    points = directions_at(rng.uniform(37.0, 53.0, 3000), rng.uniform(-4.0, 24.0, 3000)) * RADIUS_M
    found = country.gradients(points, RADIUS_M, None)
    for axis in range(3):
        step = np.zeros((3, 1))
        step[axis] = 0.5
        (high, high_rest), (low, low_rest) = country.heights(points + step), country.heights(points - step)
        assert np.abs(high - low - found.d_height[axis]).max() < 1e-5
        assert np.abs(high_rest - low_rest - found.d_rest[axis]).max() < 1e-9


def test_wide_spacings_show_coarser_levels(tmp_path):
    """Slopes of noise shrink with the spacing."""
    values = np.random.default_rng(7).normal(1000.0, 20.0, (601, 601))
    write_hgt(tmp_path, 46, 7, 601, np.rint(values).astype(np.int16))
    ground, count = ground_of(tmp_path), 2000
    points = directions_at(np.full(count, 46.5), np.linspace(7.2, 7.8, count)) * RADIUS_M
    steep = [
        float(np.sqrt((ground.gradients(points, RADIUS_M, np.full(count, spacing)).d_height ** 2).sum(axis=0).mean()))
        for spacing in (10.0, 150.0, 300.0, 600.0, 1200.0, 2400.0)
    ]
    assert all(b <= a * 1.001 for a, b in itertools.pairwise(steep)) and steep[-1] < 0.1 * steep[0]


def test_memory_is_kept_to(tmp_path, caplog):
    """Sixteen times as many samples as fit: read at a quarter of the resolution, and said so."""
    write_country(tmp_path, 40, 0, 4, 4, 601)
    with caplog.at_level(logging.WARNING):
        ground = ground_of(tmp_path, 6_000_000)
    assert "1/4 of its resolution" in caplog.text and "height_map_most_mb" in caplog.text
    assert sum(level.heights.nbytes + level.weights.nbytes for level in ground.levels) < 8_000_000
    rng = np.random.default_rng(6)
    latitude, longitude = rng.uniform(40.5, 43.5, 2000), rng.uniform(0.5, 3.5, 2000)
    assert np.abs(at(ground, latitude, longitude)[0] - land(latitude, longitude)).max() < 5.0


def test_only_new_files_are_looked_at(tmp_path, monkeypatch):
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path / "cache"))
    folder = write_country(tmp_path / "tiles", 40, 0, 2, 3, 5)
    from planetfall.engine.real_ground import tile_index

    looked = []
    find = tile_index.find_tile
    monkeypatch.setattr(tile_index, "find_tile", lambda *a: (looked.append(a[0].name), find(*a))[1])
    first = open_tiles(str(folder), "x")
    assert len(looked) == 6 and len(first) == 1
    looked.clear()
    again = open_tiles(str(folder), "x")
    assert not looked and again[0].names == first[0].names and np.array_equal(again[0].where, first[0].where)
    write_hgt(folder, 42, 0, 5)
    assert len(open_tiles(str(folder), "x")[0]) == 7 and looked == ["N42E000.hgt"]


def test_levels_are_kept_and_the_same(tmp_path, monkeypatch):
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path / "cache"))
    folder = str(write_country(tmp_path / "tiles", 40, 0, 2, 2, 31))
    made, file = make_ground(folder, MOST, "x")
    assert file.exists() and not list(file.parent.glob("*.part"))
    monkeypatch.setattr(resident, "resident_ground", lambda *a: pytest.fail("read again"))
    again = make_ground(folder, MOST, "x")[0]
    latitude, longitude = np.linspace(39.0, 43.0, 500), np.linspace(-1.0, 3.0, 500)
    np.testing.assert_array_equal(at(again, latitude, longitude)[0], at(made, latitude, longitude)[0])


def test_kept_levels_that_are_damaged_are_read_again(tmp_path, monkeypatch, caplog):
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path / "cache"))
    folder = str(write_country(tmp_path / "tiles", 40, 0, 1, 1, 31))
    file = make_ground(folder, MOST, "x")[1]
    for damage in (file.read_bytes()[:5000], b""):
        file.write_bytes(damage)
        with caplog.at_level(logging.WARNING):
            assert at(make_ground(folder, MOST, "x")[0], 40.5, 0.5)[1] == 0.0
        assert "will be written again" in caplog.text
    np.savez(file, factors=np.array([4]))
    assert at(make_ground(folder, MOST, "x")[0], 40.5, 0.5)[1] == 0.0


@pytest.mark.parametrize("most", [MOST, 1_200_000], ids=["whole", "coarser"])
def test_reading_goes_on_where_it_was_cut_off(tmp_path, monkeypatch, most):
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path / "cache"))
    from planetfall.engine.real_ground import kept_ground

    monkeypatch.setattr(kept_ground, "EVERY_S", 0.0)
    folder = str(write_country(tmp_path / "tiles", 40, 0, 2, 3, 241))
    whole = resident_ground(open_tiles(folder, "x"), most, "x")
    read, seen = resident.read_tile, []

    def cut(file: Path, *rest):
        if len(seen) == 4:
            raise KeyboardInterrupt
        seen.append(file.name)
        return read(file, *rest)

    monkeypatch.setattr(resident, "read_tile", cut)
    with pytest.raises(KeyboardInterrupt):
        make_ground(folder, most, "x")
    monkeypatch.setattr(resident, "read_tile", lambda file, *rest: (seen.append(file.name), read(file, *rest))[1])
    made, file = make_ground(folder, most, "x")
    assert len(seen) == 6 and len(set(seen)) == 6 and [p.name for p in file.parent.iterdir()] == [file.name]
    latitude, longitude = np.linspace(39.0, 43.0, 500), np.linspace(-1.0, 4.0, 500)
    np.testing.assert_array_equal(at(made, latitude, longitude)[0], at(whole, latitude, longitude)[0])
