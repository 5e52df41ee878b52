"""Scenes that go elsewhere: one file with their maps, and the format that files are of."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import planetfall as pf
from planetfall.cli.main import main
from planetfall.engine.settings import plain_table, read_toml


@pytest.fixture
def mapped(tmp_path):
    """A scene file with a height map beside it."""
    folder = tmp_path / "here"
    folder.mkdir()
    x = np.linspace(0.0, 65535.0, 64)
    Image.fromarray(np.broadcast_to(x, (32, 64)).astype(np.uint16)).save(folder / "hills.png")
    terrain = '[terrain]\nheight_map = "hills.png"\nheight_map_range_m = [-900.0, 900.0]\n'
    (folder / "mine.toml").write_text('base = "moon"\nname = "mine"\n' + terrain)
    return folder / "mine.toml"


def heights(scene):
    directions = np.random.default_rng(1).normal(size=(50, 3))
    return pf.TerrainSampler(scene).height(directions / np.linalg.norm(directions, axis=1, keepdims=True))


def test_it_opens_elsewhere(mapped, tmp_path):
    shared = tmp_path / "mine.planetfall"
    with pf.load_scene(mapped) as scene:
        assert scene.share(shared) == shared
        wanted, table = heights(scene), plain_table(scene.planet[pf.Terrain])
    (mapped.parent / "hills.png").unlink()
    with pf.load_scene(shared) as again:
        found = plain_table(again.planet[pf.Terrain])
        for name in ("height_map", "color_map"):
            assert Path(found.pop(name)).parent.name == "files" and table.pop(name)
        assert found == table
        assert again.name == "mine"
        np.testing.assert_array_equal(heights(again), wanted)
    # What it holds is found again, by name or path.
    with pf.load_scene(str(shared)) as twice:
        np.testing.assert_array_equal(heights(twice), wanted)


def test_presets_of_several_planets(tmp_path):
    with pf.load_scene("earth_moon") as scene:
        scene.share(tmp_path / "both.planetfall")
        names = list(scene.planets)
    with pf.load_scene(tmp_path / "both.planetfall") as again:
        assert list(again.planets) == names


def test_the_same_scene_makes_the_same_file(mapped, tmp_path):
    with pf.load_scene(mapped) as scene:
        one, two = (scene.share(tmp_path / f"{k}.planetfall").read_bytes() for k in "ab")
    assert one == two


def test_command(mapped, tmp_path, capsys):
    out = tmp_path / "mine.planetfall"
    assert main(["share", str(mapped), "-o", str(out)]) in (0, None)
    assert capsys.readouterr().out.strip() == str(out) and zipfile.is_zipfile(out)
    assert main(["share", str(mapped), "-o", str(tmp_path / "mine.zip")]) == 2
    assert ".planetfall" in capsys.readouterr().err


def packed(path, **files):
    with zipfile.ZipFile(path, "w") as archive:
        for name, text in files.items():
            archive.writestr(name.replace("__", "/").replace("_toml", ".toml"), text)
    return path


def test_files_that_are_none(mapped, tmp_path):
    path = tmp_path / "x.planetfall"
    with pytest.raises(pf.PresetError, match="no such file"):
        pf.load_scene(path)
    path.write_bytes(b"no zip at all")
    with pytest.raises(pf.PresetError, match="damaged"):
        pf.load_scene(path)
    with pytest.raises(pf.PresetError, match=r"has no scene.toml"):
        pf.load_scene(packed(path, files__a="x"))
    for name in ("..__evil", "files__..__..__evil", "other"):
        with pytest.raises(pf.PresetError, match="no shared scene: it holds"):
            pf.load_scene(packed(path, scene_toml='name = "x"', **{name: "x"}))
    # Cut off in the middle.
    with pf.load_scene(mapped) as scene:
        scene.share(path)
    path.write_bytes(path.read_bytes()[:-40])
    with pytest.raises(pf.PresetError, match="damaged"):
        pf.load_scene(path)
    with pf.load_scene(mapped) as scene, pytest.raises(pf.PresetError, match="doesn't exist"):
        scene.share(tmp_path / "nowhere" / "x.planetfall")


def test_a_map_that_is_gone_is_named_and_nothing_is_written(mapped, tmp_path):
    with pf.load_scene(mapped) as scene:
        (mapped.parent / "hills.png").unlink()
        with pytest.raises(pf.SettingError, match=r"hills\.png"):
            scene.share(tmp_path / "x.planetfall")
    assert not list(tmp_path.glob("*x.planetfall*"))


def test_files_say_their_format(tmp_path):
    with pf.load_scene("moon") as scene:
        scene.save(tmp_path / "moon.toml")
    assert read_toml(tmp_path / "moon.toml")["format"] == 1
    text = (tmp_path / "moon.toml").read_text()
    for wrong, match in (("2", "newer version"), ("true", "whole number"), ("-1", "whole number")):
        (tmp_path / "wrong.toml").write_text(text.replace("format = 1", f"format = {wrong}"))
        with pytest.raises(pf.PresetError, match=match):
            pf.load_scene(tmp_path / "wrong.toml")


def test_files_of_the_first_format_still_open(tmp_path):
    old = tmp_path / "old.toml"
    old.write_text('base = "moon"\n[clouds]\n[[clouds.layers]]\nkind = "water"\n[[clouds.layers]]\nkind = "ice"\n')
    with pf.load_scene(old) as scene:
        assert [layer.kind for layer in scene.planet[pf.Clouds].layers] == ["cumulus", "cirrus"]
        scene.save(tmp_path / "new.toml")
    data = read_toml(tmp_path / "new.toml")
    assert data["format"] == 1 and [layer["kind"] for layer in data["clouds"]["layers"]] == ["cumulus", "cirrus"]


def test_files_named_from_the_current_folder_are_found_from_any(mapped, tmp_path, monkeypatch):
    pytest.importorskip("trimesh", reason="the extra props is not installed")
    (tmp_path / "else" / "where").mkdir(parents=True)
    (tmp_path / "hut.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n")
    monkeypatch.chdir(tmp_path)
    with pf.load_scene("earth_moon") as scene:
        moon = scene.companions["moon"].scene
        moon.planet[pf.Terrain].height_map_range_m = (-900.0, 900.0)
        moon.planet[pf.Terrain].height_map = "here/hills.png"
        scene.add(pf.Transform((6.4e6, 0.0, 0.0)), pf.Shape("hut.obj"), name="hut")
        wanted = heights(moon)
        scene.save("else/where/own.toml")
        scene.share("own.planetfall")
    monkeypatch.chdir(tmp_path / "else")
    for file in (Path("where") / "own.toml", tmp_path / "own.planetfall"):
        with pf.load_scene(file) as again:
            np.testing.assert_array_equal(heights(again.companions["moon"].scene), wanted)
            assert Path(again.props[0][pf.Shape].form).is_file()
            # Shared once more it is the same file.
            assert again.share("again.planetfall").read_bytes() == (tmp_path / "own.planetfall").read_bytes()
    assert Path("where/own.toml").read_text().count((tmp_path / "here" / "hills.png").as_posix()) == 1
