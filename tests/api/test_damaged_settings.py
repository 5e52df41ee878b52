"""Settings files damaged in 200 random ways: an error that says what is wrong, or a scene; no crash, no loss."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

import planetfall as pf
from planetfall.app.controls import keep_controls
from planetfall.camera.kept import Place, Places
from planetfall.engine.settings import QualityKnobs
from planetfall.quality import GROUPS, QUALITY
from planetfall.scene.kinds import KINDS
from planetfall.scene.presets import load_parts, preset_names, save_preset
from planetfall.systems.flight import CONTROLS_FILE, controls_or_defaults, load_controls

ERRORS = (pf.PresetError, pf.SettingError, pf.SceneError, pf.UnknownNameError)
SEEDS = range(200)


def damaged(text: bytes, draw: random.Random) -> bytes:
    """One of many ways in which a file comes to harm: a full disk, a bad sector, an editor, a merge, a user."""
    data = bytearray(text)
    lines = text.split(b"\n")
    kind = draw.randrange(12)
    at = draw.randrange(len(data))
    if kind == 0:
        return bytes(data[:at])  # cut off
    if kind == 1:
        for _ in range(draw.randint(1, 20)):
            data[draw.randrange(len(data))] = draw.randrange(256)
        return bytes(data)
    if kind == 2:
        data[at : at + draw.randint(1, 64)] = b"\0" * draw.randint(1, 64)
        return bytes(data)
    if kind == 3:
        del data[at : at + draw.randint(1, 200)]
        return bytes(data)
    if kind == 4:
        draw.shuffle(lines)
        return b"\n".join(lines)
    if kind == 5:
        lines.insert(draw.randrange(len(lines)), draw.choice(lines))
        return b"\n".join(lines)
    if kind == 6:
        return text.decode().encode(draw.choice(["utf-16", "utf-32", "utf-8-sig"]))
    if kind == 7:
        with_numbers = [k for k, line in enumerate(lines) if b"=" in line]
        k = draw.choice(with_numbers)
        value = draw.choice(
            [b"nan", b"inf", b"-1e400", b'"a text"', b"[]", b"{}", b"true", b"1979-05-27", b"99e99", b""]
        )
        lines[k] = lines[k].partition(b"=")[0] + b"= " + value
        return b"\n".join(lines)
    if kind == 8:
        k = draw.randrange(len(lines))
        lines[k] = b"<<<<<<< HEAD\n" + lines[k] + b"\n=======\n" + lines[k] + b"\n>>>>>>> theirs"
        return b"\n".join(lines)
    if kind == 9:
        return bytes(draw.randrange(256) for _ in range(draw.randint(0, 400)))
    if kind == 10:
        return text.replace(draw.choice([b"[", b"]", b"=", b'"', b"\n", b"."]), b"", draw.randint(1, 5))
    return b"base = 'mine'\n" + text  # a file on top of itself


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("good") / "mine.toml"
    with pf.load_scene("earth") as scene:
        scene.save(path)
    return path.read_bytes()


def test_scene_files(good: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PLANETFALL_PRESETS", str(tmp_path))
    refused = 0
    with pf.load_scene("moon") as scene:
        before = scene.planet.radius_m
        for seed in SEEDS:
            text = damaged(good, random.Random(seed))
            path = tmp_path / "mine.toml"
            path.write_bytes(text)
            assert preset_names() == ["mine"]
            try:
                parts = load_parts("mine")
            except ERRORS as error:
                refused += 1
                assert "mine.toml" in str(error), (seed, error)
            else:
                assert {"Planet", "Sun", "Exposure", "Composite"} <= set(parts)
            assert path.read_bytes() == text and scene.planet.radius_m == before
            save_preset(scene, "mine")  # over what may be the only copy: it is kept
            assert (tmp_path / "mine.toml.old").read_bytes() == text
            assert load_parts("mine")["Planet"].radius_m == before
            assert {p.name for p in tmp_path.iterdir()} == {"mine.toml", "mine.toml.old"}
    assert refused > 100  # most of it is damage that can be seen


def test_quality_files(tmp_path: Path) -> None:
    good = (QUALITY.folder / "medium.toml").read_bytes()
    knobs = QualityKnobs(tmp_path, GROUPS, KINDS)
    (tmp_path / "mine.toml").write_bytes(good)
    assert knobs.resolve("mine")["terrain.edge_px"] == QUALITY.resolve("medium")["terrain.edge_px"]
    refused = 0
    for seed in SEEDS:
        text = damaged(good, random.Random(1000 + seed))
        (tmp_path / "mine.toml").write_bytes(text)
        try:
            values = knobs.resolve("mine")
        except pf.SettingError as error:
            refused += 1
            assert "mine.toml" in str(error), (seed, error)
        else:
            assert set(values) >= set(knobs.rules)
        assert (tmp_path / "mine.toml").read_bytes() == text
    assert refused > 100


def test_controls(tmp_path: Path) -> None:
    good = CONTROLS_FILE.read_bytes()
    path = tmp_path / "controls.toml"
    defaults, refused = load_controls().table(), 0
    for seed in SEEDS:
        text = damaged(good, random.Random(2000 + seed))
        path.write_bytes(text)
        controls, problem = controls_or_defaults(path)
        assert path.read_bytes() == text, seed
        if problem:
            refused += 1
            assert "controls.toml" in problem and controls.table() == defaults, seed
        keep_controls(controls, path, keep_old=True)
        assert (tmp_path / "controls.toml.old").read_bytes() == text
        assert load_controls(path).table() == controls.table(), seed
    assert refused > 100
    assert {p.name for p in tmp_path.iterdir()} == {"controls.toml", "controls.toml.old"}


def test_places(tmp_path: Path) -> None:
    whole, over = Places(tmp_path / "whole.toml"), pf.load_scene("earth").planet
    for number in range(3):
        camera = pf.Camera.at(10.0 * number, 5.0, 900.0, planet=over)
        whole.keep(Place(f"place {number}", "earth", camera, pf.Sun(), 2.0, "ship"))
    good, path = (tmp_path / "whole.toml").read_bytes(), tmp_path / "places.toml"
    refused = 0
    for seed in SEEDS:
        text = damaged(good, random.Random(3000 + seed))
        path.write_bytes(text)
        places = Places(path)
        assert path.read_bytes() == text, seed
        if places.problem:
            refused += 1
            assert "places.toml" in places.problem and places.names() == []
            places.keep(whole["place 1"])  # the first change puts what can't be read aside
            (aside,) = tmp_path.glob("places.damaged*.toml")
            assert aside.read_bytes() == text
            aside.unlink()
            assert Places(path).names() == ["place 1"]
    assert refused > 100


def test_a_file_that_cannot_be_kept_is_not_replaced(
    good: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PLANETFALL_PRESETS", str(tmp_path))
    (tmp_path / "mine.toml").write_bytes(good)
    (tmp_path / "mine.toml.old").mkdir()  # in the way
    with pf.load_scene("moon") as scene, pytest.raises(pf.PresetError, match=r"can't be kept as mine\.toml\.old"):
        save_preset(scene, "mine")
    assert (tmp_path / "mine.toml").read_bytes() == good


@pytest.mark.parametrize("name", ["x" * 300, "CON", "nul.old", "com1", ".hidden", "a/b", "  "])
def test_names_that_make_no_preset(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    """Too long for a file, or a device elsewhere: told before anything is written."""
    monkeypatch.setenv("PLANETFALL_PRESETS", str(tmp_path / "mine"))
    with pf.load_scene("moon") as scene, pytest.raises(pf.PresetError, match=r"name"):
        save_preset(scene, name)
    assert not (tmp_path / "mine").exists()
