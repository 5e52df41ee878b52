"""`planetfall map`: what folders of elevation tiles hold, and reading them before a scene does; pf.read_place."""

from __future__ import annotations

import numpy as np
import pytest
from countries import hgt_samples, land, write_country, write_fields, write_hgt, write_png_tile
from geotiffs import of_code, write_geotiff
from PIL import Image
from vector_kit import feature, polygon, write_map

import planetfall as pf
from planetfall.cli.main import main
from planetfall.engine.real_ground.color_reading import real_colors
from planetfall.engine.real_ground.survey import survey
from planetfall.engine.real_ground.tile_index import open_tiles
from planetfall.engine.wavelengths import DISPLAY_NM


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Two by three tiles, of which one is missing and one is half a void."""
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path / "cache"))
    path = write_country(tmp_path / "tiles", 46, 7, 2, 3, 31)
    (path / "N47E008.hgt").unlink()
    holed = hgt_samples(46, 9, 31)
    holed[:, 16:] = -32768
    write_hgt(path, 46, 9, 31, holed)
    return path


def test_a_survey_counts(folder):
    (facts,), picture = survey(open_tiles(str(folder), "map"), 90)
    assert (len(facts.tiles), facts.missing, facts.voids, facts.samples) == (5, 1, 31 * 15, 5 * 31 * 31)
    np.testing.assert_allclose(facts.bounds_deg, (46.0, 7.0, 48.0, 10.0), atol=1e-9)
    heights = [hgt_samples(*place, 31) for place in ((46, 7), (46, 8), (47, 7), (47, 9))]
    heights.append(hgt_samples(46, 9, 31)[:, :16])
    assert facts.lowest_m == min(h.min() for h in heights) and facts.highest_m == max(h.max() for h in heights)
    assert picture is not None and picture.shape == (60, 90)
    gaps = np.isnan(picture)
    assert gaps[5:25, 35:55].all() and gaps[35:55, 80:].all() and not gaps[5:25, 5:25].any()


def test_info_says_and_draws(folder, tmp_path, capsys):
    out = tmp_path / "map.png"
    assert main(["map", "info", str(folder), "-o", str(out), "--width-px", "90"]) == 0
    said = capsys.readouterr().out
    for words in ("3,706 m", "46.000 to", "48.000", "10.000", " 9.68 %", str(out)):
        assert words in said, said
    with Image.open(out) as picture:
        assert picture.size == (90, 60) and np.asarray(picture)[15, 45, 2] > np.asarray(picture)[15, 45, 0]


def test_info_goes_the_shorter_way_around(tmp_path, monkeypatch, capsys):
    """Four degrees at the date line are four degrees, whichever set is on which side."""
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path / "cache"))
    write_country(tmp_path / "t", 10, 178, 1, 4, 31)
    write_country(tmp_path / "t", 10, -178, 1, 1, 61)
    sets = open_tiles(str(tmp_path / "t"), "map")
    found, picture = survey(sets, 100)
    for facts in found:
        south, west, north, east = facts.bounds_deg
        assert (round(south, 6), round(north, 6)) == (10.0, 11.0)
        assert (round(west, 6), round(east, 6)) == ((178.0, 182.0) if len(facts.tiles) == 4 else (-178.0, -177.0))
        assert facts.missing == 0
    assert picture is not None and picture.shape == (20, 100) and not np.isnan(picture[1:-1, 1:-1]).any()
    jumps = np.abs(np.diff(picture[10]))
    assert jumps.max() < 5.0 * np.median(jumps) + 10.0
    out = tmp_path / "map.png"
    assert main(["map", "info", str(tmp_path / "t"), "-o", str(out), "--width-px", "100"]) == 0
    said = capsys.readouterr().out
    assert "178.000 to" in said and "182.000" not in said and "-177.000" in said
    with Image.open(out) as shown:
        assert shown.size == (100, 20)


def test_wide_samples_make_no_grid(tmp_path):
    """Pixels between samples are on the straight way between them, from tile to tile and next to finer sets, too: the
    field to its curvature, 3 m, and the half metre that files round; with the nearest samples it was 30 m."""
    write_country(tmp_path / "coarse", 44, 5, 4, 5, 21)
    write_hgt(tmp_path / "fine", 46, 7, 101)
    found, picture = survey(open_tiles(str(tmp_path), "x"), 500)
    assert len(found) == 2 and picture is not None and picture.shape == (400, 500)
    latitude, longitude = 48.0 - (np.arange(400) + 0.5) / 100.0, 5.0 + (np.arange(500) + 0.5) / 100.0
    assert np.abs(picture - land(latitude[:, None], longitude)).max() < 4.0


def test_tiles_a_sample_apart_leave_no_gap(tmp_path):
    """Their pixels are areas and wider than the picture's."""
    for x in range(130, 136):
        for y in range(88, 92):
            write_png_tile(tmp_path, 8, x, y, 8)
    write_png_tile(tmp_path, 12, 133 * 16, 90 * 16, 64)
    _, picture = survey(open_tiles(str(tmp_path), "x"), 300)
    assert picture is not None and picture.shape[1] == 300 and np.isfinite(picture).all()
    assert np.abs(np.diff(picture, axis=1)).max() < 40.0  # from sample to sample it is 103 m


def test_a_map_of_all_the_planet_is_shown_whole(tmp_path, monkeypatch):
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path / "cache"))
    write_country(tmp_path / "t", 0, -180, 1, 360, 3)
    (facts,), picture = survey(open_tiles(str(tmp_path / "t"), "map"), 360)
    np.testing.assert_allclose(facts.bounds_deg, (0.0, -180.0, 1.0, 180.0), atol=1.0)
    assert picture is not None and picture.shape[1] >= 359 and facts.missing == 0


def test_info_says_which_systems_files_are_in(tmp_path, monkeypatch, capsys):
    pytest.importorskip("pyproj")
    pytest.importorskip("tifffile")
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path / "cache"))
    values = np.full((40, 40), 700.0, np.float32)
    values[:8] = np.nan
    for j, i in ((0, 0), (0, 1), (1, 1)):
        place = (2.6e6 + 400.0 * i, 1.2e6 - 400.0 * j, 10.0)
        write_geotiff(tmp_path / f"t/{j}{i}.tif", values, of_code(2056), place)
    write_hgt(tmp_path / "t", 46, 9, 31)
    out = tmp_path / "map.png"
    assert main(["map", "info", str(tmp_path / "t"), "-o", str(out), "--width-px", "200"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    for words in ("in EPSG:2056: 3 (CH1903+ / LV95, known to 1 m)", "in degrees: 1", "700 to 700 m", " 1 "):
        assert words in said, said
    (facts,) = (f for f in survey(open_tiles(str(tmp_path / "t"), "map"))[0] if len(f.tiles) == 3)
    assert facts.missing == 1 and abs(facts.voids / facts.samples - 0.2) < 0.02


def test_info_names_broken_tiles(folder, capsys):
    whole = folder / "N46E007.hgt"
    whole.write_bytes(whole.read_bytes()[:100])
    assert main(["map", "info", str(folder)]) == 0
    streams = capsys.readouterr()
    # The console breaks long paths wherever a line ends.
    assert "N46E007.hgthas100bytes" in "".join((streams.out + streams.err).split())


def test_make_keeps_what_scenes_need(folder, tmp_path, capsys):
    assert main(["map", "make", str(folder), "--memory-mb", "64"]) == 0
    file = capsys.readouterr().out.splitlines()[-1]
    assert file.endswith(".npz") and file.startswith(str(tmp_path / "cache"))
    assert main(["map", "make", str(folder), "--memory-mb", "64"]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == file


def test_a_folder_without_tiles_is_one_line(tmp_path, capsys):
    assert main(["map", "info", str(tmp_path)]) == 2
    assert "no tile of elevation" in capsys.readouterr().err


@pytest.mark.parametrize(
    "wrong", [("info", "--width-px", "0"), ("make", "--memory-mb", "-3"), ("make", "--memory-mb", "nan")]
)
def test_numbers_out_of_range_are_one_line(folder, capsys, wrong):
    assert main(["map", wrong[0], str(folder), *wrong[1:]]) == 2
    assert "expected" in capsys.readouterr().err


def test_without_a_cache_nothing_can_be_kept(folder, monkeypatch, capsys):
    monkeypatch.setenv("PLANETFALL_CACHE", "")
    assert main(["map", "make", str(folder)]) == 2
    assert "PLANETFALL_CACHE" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("46°33'N 7°59'E", (46.55, 7.0 + 59.0 / 60.0)),
        ("N46°33'25\" E007°59'3.5\"", (46.0 + 33.0 / 60.0 + 25.0 / 3600.0, 7.0 + 59.0 / 60.0 + 3.5 / 3600.0)),
        ("46° 33′ 25″ N, 7° 59′ 3″ E", (46.0 + 33.0 / 60.0 + 25.0 / 3600.0, 7.0 + 59.0 / 60.0 + 3.0 / 3600.0)),
        ("46°33.5'N 7°59.25'E", (46.0 + 33.5 / 60.0, 7.0 + 59.25 / 60.0)),
        ("7°59'E 46°33'N", (46.55, 7.0 + 59.0 / 60.0)),
        ("46.55, 7.98", (46.55, 7.98)),
        ("-33.5;-70.25", (-33.5, -70.25)),
        ("33.5S 70.25W", (-33.5, -70.25)),
        ("46.2 N 2.1 W", (46.2, -2.1)),
    ],
)
def test_places_as_maps_print_them(text, place):
    np.testing.assert_allclose(pf.read_place(text), place, atol=1e-12)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "x",
        "46",
        "46 7 8",
        "46,5 7,9",
        "46°70'N 7°E",
        "46N 7",
        "46N 7N",
        "-46N 7E",
        "46.5°30'N 7°E",
        "91, 4",
        "46 N 2 O",
    ],
)
def test_what_is_no_place_says_what_is(text):
    with pytest.raises(pf.CameraError, match=r"read_place: .*expected"):
        pf.read_place(text)


def test_info_knows_pictures(tmp_path, capsys):
    """Tiles of pictures by what they look like, and by the index; tiles of terrain-RGB stay heights."""
    write_fields(tmp_path / "fields", 14, 46.5, 7.5, 2)
    out = tmp_path / "map.png"
    assert main(["map", "info", str(tmp_path / "fields"), "-o", str(out), "--width-px", "90"]) == 0
    said = capsys.readouterr().out
    assert "colors" in said and "9.5 m" in said and " 0.00 %" in said
    with Image.open(out) as picture:
        assert np.asarray(picture)[30, 30, 0] > np.asarray(picture)[30, 30, 2] and max(picture.size) == 90
    write_png_tile(tmp_path / "heights", 12, 2138, 1443)
    assert main(["map", "info", str(tmp_path / "heights")]) == 0
    assert "heights" in capsys.readouterr().out
    assert main(["map", "info", str(tmp_path / "heights"), "--kind", "colors"]) == 0
    assert "colors" in capsys.readouterr().out
    (tmp_path / "map.toml").write_text('[[tiles]]\nfolder = "fields"\nkind = "colors"\n')
    assert main(["map", "info", str(tmp_path / "map.toml")]) == 0
    assert "colors" in capsys.readouterr().out


def test_make_keeps_pictures(tmp_path, monkeypatch, capsys):
    """The file has all that a scene reads from tiles, so these need not be opened."""
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path / "cache"))
    write_fields(tmp_path / "fields", 14, 46.5, 7.5, 2, "jpg")
    read = real_colors(str(tmp_path / "fields"), DISPLAY_NM, 32_000_000, "map")
    assert main(["map", "make", str(tmp_path / "fields"), "--memory-mb", "64"]) == 0
    file = capsys.readouterr().out.splitlines()[-1]
    assert file.endswith(".npz") and file.startswith(str(tmp_path / "cache"))
    for reader in ("color_pixels", "color_blocks"):
        monkeypatch.setattr(f"planetfall.engine.real_ground.{reader}.read_color_tile", None)
    kept = real_colors(str(tmp_path / "fields"), DISPLAY_NM, 64_000_000, "map")
    assert len(kept.sets) == 1 and kept.sets[0].octaves == read.sets[0].octaves
    for a, b in zip(kept.sets[0].levels, read.sets[0].levels, strict=True):
        assert a.lattice == b.lattice and (a.where == b.where).all() and (a.pixels == b.pixels).all()


def test_a_vector_map_is_counted(tmp_path, capsys):
    square = [[7.0, 46.0], [7.1, 46.0], [7.1, 46.1], [7.0, 46.1], [7.0, 46.0]]
    path = write_map(
        tmp_path / "a.geojson",
        feature(polygon(square), natural="water"),
        feature(polygon(square[:-1]), landuse="forest"),
        feature(polygon(square), landuse="orchard"),
    )
    assert main(["map", "info", path]) == 0
    out = capsys.readouterr().out
    assert all(word in out for word in ("lake", "forest", "46.0000 to 46.1000"))
    assert "repaired: 1 rings" in out and "ignored: 1 (landuse=orchard)" in out
