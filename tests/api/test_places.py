"""Places kept: saved at once, whole, and never lost."""

from __future__ import annotations

import random
from pathlib import Path

import numpy as np
import pytest

import planetfall as pf
from planetfall.camera.kept import Place, Places


def place(name: str, scene: str = "earth", **more) -> Place:
    over = pf.load_scene("earth").planet
    camera = pf.Camera.at(
        12.3456789, -45.6, 789.0123456789, heading_deg=33.0, pitch_deg=-7.0, fov_y_deg=41.0, planet=over
    )
    return Place(name, scene, camera, pf.Sun(elevation_deg=12.0, azimuth_deg=99.0), 1234.5, **more)


def test_places_come_back(tmp_path: Path) -> None:
    file = tmp_path / "new" / "places.toml"
    kept = Places(file)
    kept.keep(place("beach", mode="walk"))
    kept.keep(place("höhe ☀"))
    again = Places(file)
    assert again.names() == ["beach", "höhe ☀"] and again.problem == ""
    found, wanted = again["beach"], place("beach")
    for name in ("position_m", "forward", "up"):
        # Axes are made orthonormal once more; the position is that of the file.
        np.testing.assert_allclose(getattr(found.camera, name), getattr(wanted.camera, name), rtol=0, atol=1e-15)
    assert (found.sun, found.time_s, found.mode, found.camera.fov_y_deg) == (wanted.sun, 1234.5, "walk", 41.0)
    assert [f.name for f in file.parent.iterdir()] == ["places.toml"]


def test_a_name_is_one_place(tmp_path: Path) -> None:
    kept = Places(tmp_path / "places.toml")
    kept.keep(place("a"))
    kept.keep(place("b", scene="mars"))
    kept.keep(place("a", mode="orbit"))
    assert kept.names() == ["a", "b"] and kept["a"].mode == "orbit" and kept.free_name("a") == "a 2"
    with pf.load_scene("mars") as scene:
        assert kept.names(scene) == (["b"] if scene.name == "mars" else [])
    kept.forget("a")
    assert Places(tmp_path / "places.toml").names() == ["b"]
    with pytest.raises(pf.UnknownNameError, match="no place 'c'"):
        kept.forget("c")
    with pytest.raises(pf.PresetError, match="needs a name"):
        kept.keep(place("  "))


def test_what_a_place_cannot_keep_is_refused(tmp_path: Path) -> None:
    at, lens = ((7e6, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0)), pf.Intrinsics(64, 36, 50.0, 50.0, 31.5, 17.5)
    kept = Places(tmp_path / "places.toml")
    for camera in (
        pf.Camera(*at, intrinsics=lens),
        pf.Camera(*at, ev100=9.0),
        pf.Camera(*at, frustum_deg=(-9, 9, 0, 9)),
    ):
        with pytest.raises(pf.PresetError, match="kept by pictures"):
            kept.keep(Place("lens", "earth", camera, pf.Sun(), 0.0))
    assert not kept.file.exists()


def test_a_damaged_file_is_put_aside_and_never_lost(tmp_path: Path) -> None:
    file, rng = tmp_path / "places.toml", random.Random(11)
    kept = Places(file)
    for name in "abc":
        kept.keep(place(name))
    whole = file.read_bytes()
    broken = 0
    for _ in range(200):
        data = bytearray(whole)
        for _ in range(rng.randint(1, 5)):
            at = rng.randrange(max(len(data), 1))
            data[at : at + rng.randint(0, 30)] = bytes(rng.randrange(256) for _ in range(rng.randint(0, 10)))
        file.write_bytes(data)
        damaged = Places(file)
        assert file.read_bytes() == bytes(data)  # reading changes nothing
        if damaged.problem:
            broken += 1
            assert str(file) in damaged.problem and damaged.names() == []
            assert "left as it is, and is put aside" in damaged.problem
            damaged.keep(place("new"))
            aside = [f for f in tmp_path.iterdir() if f.name != "places.toml"]
            assert [f.read_bytes() for f in aside] == [bytes(data)]
            assert Places(file).names() == ["new"]
            aside[0].unlink()
    assert broken > 100


def test_what_cannot_be_written_changes_nothing(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    kept = Places(tmp_path / "file" / "places.toml")
    with pytest.raises(pf.PresetError, match="can't be written"):
        kept.keep(place("a"))
    assert kept.names() == []
