"""`planetfall map rivers`: from tiles to a vector map that a scene takes, and what it says where it can't."""

from __future__ import annotations

import json

import numpy as np
import pytest
from countries import write_hgt

import planetfall as pf
from planetfall.cli.main import main

LATITUDE, LONGITUDE = 46.5, 7.5


@pytest.fixture
def valley(tmp_path, monkeypatch):
    """A valley that winds to the south, of samples of 9 seconds."""
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path / "cache"))
    step = np.arange(401) / 400.0
    longitude, latitude = np.meshgrid(7.0 + step, 47.0 - step)
    across_km = (longitude - axis_of(latitude)) * 76.0
    heights = 900.0 + 800.0 * (latitude - 46.0) + 900.0 * np.tanh(across_km / 6.0) ** 2
    write_hgt(tmp_path / "tiles", 46, 7, 401, np.rint(heights).astype(np.int16))
    return tmp_path / "tiles"


def axis_of(latitude):
    return LONGITUDE + 0.05 * np.sin(12.0 * (latitude - 46.0))


def test_rivers_are_found_written_and_drawn(valley, tmp_path, capsys):
    out = tmp_path / "rivers.geojson"
    assert main(["map", "rivers", str(valley), "-o", str(out), "--lakes"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert str(out) in "".join(said.split()) or str(out) in said
    assert "401 x 401 cells, 278 m apart" in said and "the border" in said and "300 mm of runoff" in said
    features = json.loads(out.read_text())["features"]
    main_river = [f for f in features if f["properties"].get("river") == 1]
    last = main_river[-1]
    assert last["geometry"]["coordinates"][-1][1] < 46.01 and last["properties"]["catchment_cut"]
    assert main(["map", "info", str(out)]) == 0
    assert "river" in capsys.readouterr().out
    # As a scene has it: water in the valley's floor, neither above its banks nor far below them.
    scene = pf.load_scene("earth")
    terrain = scene.planet[pf.Terrain]
    terrain.rivers, terrain.height_map_detail = 0.0, 0.0
    terrain.height_map = str(valley)
    plain = pf.TerrainSampler(scene)
    line = np.concatenate([np.array(f["geometry"]["coordinates"]) for f in main_river])
    line = line[(line[:, 1] > 46.1) & (line[:, 1] < 46.9)]
    ground = plain.height(pf.direction(line[:, 1], line[:, 0]))
    terrain.vector_map = str(out)
    water = pf.TerrainSampler(scene).water(pf.direction(line[:, 1], line[:, 0]))
    wide = np.array([f["properties"]["width"] for f in main_river])
    assert wide.max() > 15.0
    # Samples of the shore are 30 m apart in so large a country, and cells of the ground 280 m.
    wet = water.depth_m > 0.2
    assert wet.mean() > 0.95
    over = (ground - water.level_m)[wet]
    assert over.min() > -0.1 and np.percentile(over, 90) < 6.0
    assert (np.abs(line[:, 0] - axis_of(line[:, 1])) < 1.0 / 400.0).mean() > 0.95


def test_a_box_and_a_spacing_are_kept(valley, tmp_path, capsys):
    out = tmp_path / "part.geojson"
    box = ["--box", "7.2", "46.3", "7.8", "46.7"]
    assert main(["map", "rivers", str(valley), "-o", str(out), *box, "--spacing", "600", "--springs", "20"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "120 x 80 cells, 556 m apart, 2 of the tiles' 278 m; streams from 20 km2" in said
    places = np.concatenate([f["geometry"]["coordinates"] for f in json.loads(out.read_text())["features"]])
    assert places[:, 0].min() >= 7.2 and places[:, 0].max() <= 7.8
    assert places[:, 1].min() >= 46.3 and places[:, 1].max() <= 46.7


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--box", "10", "46", "11", "47"], "--box 10 46 11 47: no tile of"),
        (["--box", "8", "46", "7", "47"], "west below east"),
        (["--spacing", "0"], "--spacing: 0; expected more than 0"),
        (["--springs", "-1"], "--springs: -1; expected more than 0"),
        (["--runoff", "nan"], "--runoff: nan"),
        (["--lake-depth", "0"], "--lake-depth: 0"),
        (["--sea", "5000"], "no land"),
        (["--sea", "inf"], "--sea: inf"),
        (["--spacing", "90000"], "expected 3 x 3 or more"),
    ],
)
def test_bad_options_write_nothing(valley, tmp_path, capsys, options, words):
    out = tmp_path / "rivers.geojson"
    assert main(["map", "rivers", str(valley), "-o", str(out), *options]) == 2
    assert words in " ".join(capsys.readouterr().err.split())
    assert not out.exists() and not list(tmp_path.glob(".rivers*"))


def test_bad_folders_and_names_write_nothing(valley, tmp_path, capsys):
    (tmp_path / "empty").mkdir()
    out = tmp_path / "rivers.geojson"
    assert main(["map", "rivers", str(tmp_path / "empty"), "-o", str(out)]) == 2
    assert "has no tile of elevation" in " ".join(capsys.readouterr().err.split())
    assert main(["map", "rivers", str(tmp_path / "none"), "-o", str(out)]) == 2
    assert "neither a folder of tiles" in " ".join(capsys.readouterr().err.split())
    assert main(["map", "rivers", str(valley), "-o", str(tmp_path / "rivers.png")]) == 2
    assert "ends in .geojson" in " ".join(capsys.readouterr().err.split())
    assert main(["map", "rivers", str(valley), "-o", str(tmp_path / "no" / "such.geojson")]) == 2
    write_hgt(tmp_path / "void", 46, 7, 31, np.full((31, 31), -32768, np.int16))
    capsys.readouterr()
    assert main(["map", "rivers", str(tmp_path / "void"), "-o", str(out)]) == 2
    assert "has a height" in " ".join(capsys.readouterr().err.split())
    assert not out.exists()
