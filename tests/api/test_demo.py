"""The demo and the command line with the real renderer: small pictures from start to end."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import planetfall as pf
from planetfall.cli.main import main as cli
from planetfall.games.demo_planet.main import main as demo
from planetfall.systems.capture import read_arrays, read_png_settings

pytestmark = pytest.mark.gpu


def test_without_a_display_the_flight_is_rendered(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "flight"
    arguments = ["--headless", "--count", "4", "--size", "64x36", "--quality", "low", "-o", str(out)]
    assert demo(arguments) == 0
    text = capsys.readouterr().out
    frames = sorted(out.glob("frame_*.png"))
    assert len(frames) == 4 and frames[0].name in text
    assert "contact_sheet.png" in text and "flight.mp4" in text
    pictures = [np.asarray(Image.open(frame)).astype(float) for frame in frames]
    assert all(picture.max() > 60 for picture in pictures)
    assert pictures[0].mean() < pictures[-1].mean()  # a small disc in black space, then ground
    stamp = frames[0].stat().st_mtime_ns
    assert demo(arguments) == 0
    assert frames[0].stat().st_mtime_ns == stamp
    capsys.readouterr()
    assert demo([*arguments, "--quality", "medium"]) == 2
    assert "made with other settings" in capsys.readouterr().out


def test_with_a_display_it_flies(monkeypatch: pytest.MonkeyPatch) -> None:
    flown: list[dict[str, Any]] = []
    monkeypatch.setattr(pf, "has_display", lambda: True)
    monkeypatch.setattr(pf, "fly", lambda scene, start, **options: flown.append({"scene": scene.name, **options}))
    assert demo(["moon", "--window", "pyglet", "--size", "320x200"]) == 0
    assert flown == [{"scene": "moon", "size": (320, 200), "quality": None, "window": "pyglet"}]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["erth", "--headless"], "did you mean 'earth'?"),
        (["--headless", "--path", "lwo"], "did you mean 'low'?"),
        (["--headless", "--quality", "hihg"], "did you mean 'high'?"),
    ],
)
def test_bad_names_are_one_line(
    arguments: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert demo([*arguments, "-o", str(tmp_path)]) == 2
    assert message in capsys.readouterr().out


def test_folders_are_tried_before_anything_is_rendered(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from planetfall.render import renderer

    monkeypatch.setattr(renderer.Renderer, "__init__", lambda *_, **__: pytest.fail("rendered before looking"))
    file = tmp_path / "file"
    file.write_text("")
    with pytest.raises(pf.expected_errors(), match=r"the output folder .*file cannot be made"):
        pf.record(pf.load_scene("earth"), "descent", file, count=2)
    assert demo(["--headless", "--count", "2", "-o", str(file)]) == 2
    assert "cannot be made" in capsys.readouterr().out
    with pytest.raises(pf.PresetError, match="did you mean 'descent'"):
        pf.record(pf.load_scene("earth"), "decent", tmp_path / "new")
    assert not (tmp_path / "new").exists()


def test_bad_options_are_explained(capsys: pytest.CaptureFixture[str]) -> None:
    for arguments, message in ((["--size", "big"], "width x height"), (["--count", "0"], "at least 1")):
        with pytest.raises(SystemExit):
            demo(arguments)
        said = capsys.readouterr().err
        assert message in said and said.startswith("usage: demo_planet ")


def test_the_command_line_renders_a_picture(tmp_path: Path) -> None:
    target = tmp_path / "a.png"
    command = ["render", "earth", "--view", "high", "--size", "64x36", "--quality", "low", "-o", str(target)]
    assert cli(command) == 0
    assert np.asarray(Image.open(target)).max() > 60
    first = target.read_bytes()
    assert cli(command) == 0
    assert target.read_bytes() == first  # the same picture every time
    assert read_png_settings(target)["view"] == "high"


def test_the_command_line_writes_arrays(tmp_path: Path) -> None:
    target = tmp_path / "a.npz"
    assert cli(["render", "--latitude-deg", "0", "--longitude-deg", "0", "--altitude-m", "1e6", "--pitch-deg", "-90",
                "--size", "32x18", "--quality", "low", "-o", str(target)]) == 0  # fmt: skip
    arrays, _ = read_arrays(target)
    assert arrays["color"].shape == (18, 32, 3) and arrays["distance"].shape == (18, 32)
    assert arrays["distance"][9, 16] == pytest.approx(1e6, rel=0.02)
    assert set(np.unique(arrays["surface"])) <= {0, 1, 2}


def test_the_command_line_names_what_is_wrong(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for options, message in (
        (["--quality", "hihg"], "did you mean 'high'?"),
        (["--set", "terrain.edge_pxx=3"], "terrain.edge_px"),
        (["--set", "terrain.edge_px=-3"], "terrain.edge_px"),
        (["--size", "99999x10"], "expected at most 65536 pixels a side, found '99999x10'"),
    ):
        assert cli(["render", *options, "-o", str(tmp_path / "a.png")]) == 2
        assert message in capsys.readouterr().err.replace("\n", " ")
    assert not list(tmp_path.iterdir())


def test_the_graph_is_shown(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli(["graph", "--size", "32x18", "--quality", "low"]) == 0
    assert "terrain" in capsys.readouterr().out
    assert cli(["graph", "--size", "32x18", "--quality", "low", "--explain", "composite.tonemap"]) == 0
    assert "composite.tonemap" in capsys.readouterr().out
    assert cli(["graph", "--size", "32x18", "--quality", "low", "--passes"]) == 0
    assert cli(["graph", "--explain", "composite.tonemapp"]) == 2
