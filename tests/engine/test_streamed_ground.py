"""Real elevation that doesn't fit into its budget: the same heights, page by page; what is kept, and what breaks."""

from __future__ import annotations

import logging
import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from countries import hgt_samples, land, write_country, write_hgt, write_png_tile

from planetfall.engine.real_ground import page_files, resident, tile_scan
from planetfall.engine.real_ground.lattice import directions_at
from planetfall.engine.real_ground.resident import forget_ground, make_ground, real_ground
from planetfall.engine.real_ground.streamed_ground import StreamedGround
from planetfall.engine.real_ground.streamed_level import StreamedLevel
from planetfall.engine.settings import SettingError

RADIUS_M = 6.371e6
WHOLE, FEW = 256_000_000, 6_000_000


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache" / "real_ground"


def write_rough(folder, south=40, west=0, rows=4, columns=4, side=481):
    """Tiles of noise that agree at their borders."""
    rng = np.random.default_rng(3)
    for j in range(rows):
        for i in range(columns):
            values = hgt_samples(south + j, west + i, side).astype(float)
            values[1:-1, 1:-1] += rng.normal(0.0, 15.0, (side - 2, side - 2))
            write_hgt(folder, south + j, west + i, side, np.rint(values).astype(np.int16))
    return folder


@pytest.fixture(scope="module")
def country(tmp_path_factory):
    """Tiles of 7.5 seconds, one of which has a hole, on tiles of a minute, and PNG tiles of 76 m on them."""
    folder = tmp_path_factory.mktemp("country")
    write_rough(folder / "fine")
    holed = hgt_samples(42, 2, 481)
    holed[100:300, 50:400] = -32768
    write_hgt(folder / "fine", 42, 2, 481, holed)
    write_country(folder / "coarse", 38, -3, 8, 10, 61)
    for x in range(4):
        write_png_tile(folder / "finest", 11, 1030 + x, 760)
    return folder


def places(count, south, north, west, east, seed=1):
    rng = np.random.default_rng(seed)
    return directions_at(rng.uniform(south, north, count), rng.uniform(west, east, count))


def streamed(folder, most=FEW):
    found = real_ground(str(folder), most, "Terrain.height_map", streams=True)
    assert isinstance(found, StreamedGround)
    return found


def test_heights_are_those_of_all_tiles_in_memory(country):
    """Bit by bit: heights, gradients, roughness; in tiles, at borders, in the hole, at all margins."""
    whole, few = real_ground(str(country), WHOLE, "x"), streamed(country)
    assert any(isinstance(level, StreamedLevel) for level in few.levels)
    assert not any(isinstance(level, StreamedLevel) for level in whole.levels)
    for box in ((37.0, 47.0, -5.0, 9.0), (42.3, 42.9, 2.0, 2.9), (41.99, 42.01, 1.9, 2.1), (41.9, 42.1, 1.0, 1.6)):
        points = places(600, *box) * RADIUS_M
        for a, b in zip(few.heights(points), whole.heights(points), strict=True):
            np.testing.assert_array_equal(a, b)
        rough_by = [1e-3] * len(few.levels)
        a, b = (ground.gradients(points, RADIUS_M, None, rough_by) for ground in (few, whole))
        for name in ("height_m", "rest", "d_height", "seen_rest", "d_rest"):
            np.testing.assert_array_equal(getattr(a, name), getattr(b, name))
        np.testing.assert_array_equal(a.relief.rough, b.relief.rough)
        np.testing.assert_allclose(few.slopes(points, RADIUS_M), whole.slopes(points, RADIUS_M), rtol=1e-6)
        steep = np.linalg.norm(a.d_height, axis=0)[a.rest == 0.0]
        assert not len(steep) or np.quantile(steep, 0.99) < few.steepest(RADIUS_M)


def test_the_date_line_and_poles_are_the_same(tmp_path):
    tifffile = pytest.importorskip("tifffile")
    latitude, longitude = (89.875 - 0.25 * np.arange(720))[:, None], -179.875 + 0.25 * np.arange(1440)
    keys = (1, 1, 0, 2, 1024, 0, 1, 2, 1025, 0, 1, 1)
    tags = [
        (33550, "d", 3, (0.25, 0.25, 0.0), True),
        (33922, "d", 6, (0.0, 0.0, 0.0, -180.0, 90.0, 0.0), True),
        (34735, "H", len(keys), keys, True),
    ]
    (tmp_path / "t").mkdir()
    tifffile.imwrite(tmp_path / "t" / "all.tif", land(latitude, longitude).astype(np.float32), extratags=tags)
    write_rough(tmp_path / "t", 10, 178, 2, 2)
    for west in (-180, -179):
        write_rough(tmp_path / "t", 10, west, 2, 1)
    whole, few = real_ground(str(tmp_path / "t"), WHOLE, "x"), streamed(tmp_path / "t", 4_000_000)
    for box in ((-90.0, 90.0, -180.0, 180.0), (89.0, 90.0, -180.0, 180.0), (10.0, 12.0, 179.9, 180.1)):
        points = places(800, *box)
        np.testing.assert_array_equal(few.heights(points)[0], whole.heights(points)[0])


def test_memory_stays_within_the_budget(country):
    """Whatever is asked for, and however much at once."""
    ground = streamed(country)
    worst = 0
    for seed in range(3):
        ground.heights(places(600, 39.0, 45.0, -1.0, 5.0, seed))
        worst = max(worst, ground.resident_bytes)
    assert ground.pool.loads > 4 * ground.pool.slots  # there was no room for all of it
    assert 0.5 * FEW < worst <= FEW
    assert ground.pool.samples.nbytes + ground.pool.roughness.nbytes + ground.pool.steep.nbytes <= FEW


def test_threads_get_the_same_heights(country):
    whole, few = real_ground(str(country), WHOLE, "x"), streamed(country)
    asked = [places(100, 39.0, 45.0, -1.0, 5.0, seed) for seed in range(8)]
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda points: few.heights(points)[0], asked))
    for points, heights in zip(asked, found, strict=True):
        np.testing.assert_array_equal(heights, whole.heights(points)[0])


def test_what_fits_is_as_it_was(country, caplog):
    """No page comes and goes, and without streaming sets are read coarser."""
    assert real_ground(str(country), WHOLE, "x", streams=True) is real_ground(str(country), WHOLE, "x")
    with caplog.at_level(logging.WARNING):
        assert not isinstance(real_ground(str(country), FEW, "x"), StreamedGround)
    assert "of its resolution" in caplog.text
    caplog.clear()
    with caplog.at_level(logging.WARNING):
        streamed(country)
    assert not caplog.text


def test_without_a_cache_folder_pages_come_from_tiles(country, monkeypatch):
    monkeypatch.setenv("PLANETFALL_CACHE", "")
    points = places(200, 39.0, 45.0, -1.0, 5.0)
    np.testing.assert_array_equal(
        streamed(country, FEW + 1).heights(points)[0], real_ground(str(country), WHOLE, "x").heights(points)[0]
    )


def test_where_the_cache_can_not_be_written_pages_come_from_tiles(country, tmp_path, monkeypatch, caplog):
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path / "file" / "cache"))
    forget_ground()
    points = places(200, 39.5, 44.5, -0.5, 4.5)
    with caplog.at_level(logging.WARNING):
        found = streamed(country).heights(points)[0]
    assert "can't be written" in caplog.text
    np.testing.assert_array_equal(found, real_ground(str(country), WHOLE, "x").heights(points)[0])


def test_tiles_are_read_once(tmp_path, monkeypatch):
    """The next start has its index, and pages that were made; nothing is read but pages that weren't."""
    folder = write_rough(tmp_path / "t")
    points = places(50, 40.2, 40.4, 0.2, 0.4)
    first = streamed(folder)
    level = first.levels[0]
    assert isinstance(level, StreamedLevel)
    for number in range(0, len(level.where), 7):
        level.page(number, ahead=True)
    heights = first.heights(points)[0]
    forget_ground()
    monkeypatch.setattr(resident, "read_set", lambda *a: pytest.fail("read again"))
    again = streamed(folder)
    assert again is not first
    np.testing.assert_array_equal(again.heights(points)[0], heights)


def test_reading_goes_on_where_it_was_cut_off(tmp_path, monkeypatch, cache):
    folder = write_rough(tmp_path / "t")
    whole = real_ground(str(folder), WHOLE, "x")
    monkeypatch.setattr(tile_scan, "EVERY_S", 0.0)
    means, seen, last = tile_scan.means_of, [], [8]

    def cut(fine, factor):
        seen.append(1)
        if len(seen) == last[0]:
            raise KeyboardInterrupt
        return means(fine, factor)

    monkeypatch.setattr(tile_scan, "means_of", cut)
    with pytest.raises(KeyboardInterrupt):
        make_ground(str(folder), FEW, "x", streams=True)
    last[0] = 0
    made, file = make_ground(str(folder), FEW, "x", streams=True)
    squares = len(seen) - 1
    assert file.exists() and not list(cache.glob("*.part")) and not list(cache.glob("*.reading.npz"))
    seen.clear()
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path / "other"))
    make_ground(str(folder), FEW, "x", streams=True)
    assert len(seen) in (squares, squares - 1)  # nothing was read twice, but what was under way
    points = places(400, 39.0, 45.0, -1.0, 5.0)
    np.testing.assert_array_equal(made.heights(points)[0], whole.heights(points)[0])


def test_files_that_are_damaged_or_gone_are_made_again(tmp_path, cache, caplog):
    folder = write_rough(tmp_path / "t")
    points = places(200, 39.5, 44.5, -0.5, 4.5)
    ground = streamed(folder)
    for level in ground.levels:
        if isinstance(level, StreamedLevel):
            for number in range(0, len(level.where), 9):
                level.page(number, ahead=True)
    expected = ground.heights(points)[0]
    files = sorted(path for path in cache.rglob("*") if path.is_file() and ".index" not in path.name)
    assert any(path.suffix == ".blocks" for path in files) and sum(path.suffix == ".npz" for path in files) > 4
    for number, path in enumerate(files):
        if number % 3 == 0:
            path.unlink()
        else:
            path.write_bytes(path.read_bytes()[: 100 if number % 3 == 1 else 0])
    forget_ground()
    with caplog.at_level(logging.WARNING):
        np.testing.assert_array_equal(streamed(folder).heights(points)[0], expected)
    index = next(cache.glob("*.index.npz"))
    index.write_bytes(index.read_bytes()[:3000])
    forget_ground()
    np.testing.assert_array_equal(streamed(folder).heights(points)[0], expected)


def test_the_cache_keeps_to_its_limit(tmp_path, cache, monkeypatch):
    """What was used longest ago goes."""
    monkeypatch.setenv("PLANETFALL_CACHE_MB", "3")
    folder = write_rough(tmp_path / "t")
    ground = streamed(folder)
    level = ground.levels[0]
    assert isinstance(level, StreamedLevel)
    for number in range(0, len(level.where), 3):
        level.page(number, ahead=True)
        assert sum(path.stat().st_size for path in cache.rglob("*") if path.is_file()) < 3.5e6
    points = places(200, 39.5, 44.5, -0.5, 4.5)
    np.testing.assert_array_equal(ground.heights(points)[0], real_ground(str(folder), WHOLE, "x").heights(points)[0])
    old, new, others = (tmp_path / "limit" / name for name in (f"{'0' * 40}.npz", f"{'1' * 40}.npz", "mine.tif"))
    old.parent.mkdir()
    for path, age_s in ((new, 10.0), (old, 1000.0), (others, 1e5)):
        path.write_bytes(b"0" * 1000)
        os.utime(path, (time.time() - age_s,) * 2)
    assert page_files.keep_to_limit(old.parent, 1500) == 1000 and new.exists() and not old.exists()
    assert others.exists(), "what lies beside is not ours to remove"
    monkeypatch.setenv("PLANETFALL_CACHE_MB", "much")
    with pytest.raises(SettingError, match=r"PLANETFALL_CACHE_MB: 'much'; expected megabytes above 0"):
        page_files.limit_bytes()


@pytest.mark.parametrize("kind", ["gone", "cut off"])
def test_a_tile_that_breaks_while_pages_come(tmp_path, caplog, kind):
    """One warning; the next coarser level stands there, the other tiles as before, and nothing of it is kept."""
    folder = write_rough(tmp_path / "t")
    ground = streamed(folder)
    whole = real_ground(str(folder), WHOLE, "x")
    file = folder / "N41E001.hgt"
    data = file.read_bytes()
    file.unlink() if kind == "gone" else file.write_bytes(data[:5000])
    with caplog.at_level(logging.WARNING):
        there, rest = ground.heights(places(400, 41.1, 41.9, 1.1, 1.9))
        other = places(200, 42.2, 42.8, 2.2, 2.8)
        np.testing.assert_array_equal(ground.heights(other)[0], whole.heights(other)[0])
    assert sum("N41E001.hgt" in r.getMessage() for r in caplog.records) == 1
    wanted = whole.heights(places(400, 41.1, 41.9, 1.1, 1.9))[0]
    assert not rest.any() and 5.0 < np.std(there - wanted) < 40.0  # the noise is missing


CODE = """
import resource, sys, threading
import numpy as np
from planetfall.engine.real_ground.lattice import directions_at
from planetfall.engine.real_ground.resident import real_ground
rng = np.random.default_rng(1)
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
ground = real_ground(sys.argv[1], 48_000_000, "x", streams=True)
read = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
for k in range(60):
    ground.heights(directions_at(rng.uniform(40.0, 44.0, 400), rng.uniform(0.0, 6.0, 400)))
print(before, read, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, ground.pool.loads, ground.resident_bytes)
"""


@pytest.mark.slow
def test_a_process_takes_no_more_than_that(tmp_path):
    """Tiles of 620 MB, 1250 MB as samples of pages, in a budget of 48: 150 MB beside what the program takes."""
    for j in range(4):
        for i in range(6):
            write_hgt(tmp_path / "t", 40 + j, i, 3601)
    told = subprocess.run(
        [sys.executable, "-P", "-c", CODE, str(tmp_path / "t")], check=True, capture_output=True, text=True
    )
    before, read, after, loads, resident_bytes = (int(v) for v in told.stdout.split())
    assert loads > 2000 and resident_bytes <= 48_000_000
    assert max(read, after) - before < 150_000, told.stdout


def test_folders_stay_in_place(country):
    """Asking changes no file."""
    names = sorted(str(path) for path in Path(country).rglob("*"))
    streamed(country).heights(places(100, 39.0, 45.0, -1.0, 5.0))
    assert names == sorted(str(path) for path in Path(country).rglob("*"))
