"""`planetfall gallery --best`: pictures with their settings inside, a page of all, and going on where it stopped."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from test_cli import FakeRenderer, fails, no_gpu  # noqa: F401 - the fixture stands in for the renderer

import planetfall as pf
from planetfall.benchmarks.scenes import preset_scene
from planetfall.capture.gallery import BEST, best_gallery
from planetfall.cli.main import main
from planetfall.systems.capture import CaptureError, read_jpeg_settings, write_jpeg


@pytest.fixture(autouse=True)
def cloudy(monkeypatch: pytest.MonkeyPatch) -> None:
    """Presets as they are, with clouds."""
    monkeypatch.setattr("planetfall.capture.gallery.load_scene", lambda name: preset_scene(name, clouds=True))


COMMAND = ["gallery", "--best", "--size", "32x18", "--quality", "low"]


def test_sixteen_pairs_that_there_are_over_all_planets():
    assert len(BEST) == len(set(BEST)) == 16
    assert {planet for planet, _ in BEST} == set(pf.planets())
    for planet, name in BEST:
        with preset_scene(planet, clouds=True) as scene:
            assert name in pf.views(scene.planet)


def test_pictures_and_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    assert main([*COMMAND, "-o", str(tmp_path / "a" / "gallery")]) == 0
    folder = tmp_path / "a" / "gallery"
    assert {f.name for f in folder.iterdir()} == {"README.md", *(f"{p}-{v}.jpg" for p, v in BEST)}
    page = (folder / "README.md").read_text(encoding="utf-8")
    for planet, name in BEST:
        assert f"({planet}-{name}.jpg)" in page and f"render {planet} --view {name} --quality low --size 32x18" in page
    settings = read_jpeg_settings(folder / "mars-valley.jpg")
    assert settings is not None and settings["view"] == "valley" and settings["size"] == [32, 18]
    assert Image.open(folder / "mars-valley.jpg").size == (32, 18)
    assert all(r.settled == 1 and r.released for r in FakeRenderer.made)
    assert "wrote 16 of 16 pictures" in capsys.readouterr().err


def test_it_goes_on_where_it_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    assert main([*COMMAND, "-o", str(tmp_path)]) == 0
    before = (tmp_path / "moon-ground.jpg").stat().st_mtime_ns
    (tmp_path / "hazy-limb.jpg").unlink()
    write_jpeg(tmp_path / "earth-dusk.jpg", np.zeros((18, 32, 3), np.uint8), {"of": "something else"})
    FakeRenderer.made.clear()
    assert main([*COMMAND, "-o", str(tmp_path)]) == 0
    assert len(FakeRenderer.made) == 2, "the missing one and the one of other settings"
    assert (tmp_path / "moon-ground.jpg").stat().st_mtime_ns == before

    def stop(self: Any, *_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(FakeRenderer, "settle", stop)
    assert main([*COMMAND, "--force", "-o", str(tmp_path)]) == 130
    assert (tmp_path / "earth-space.jpg").stat().st_size > 0, "what was there stays whole"


def test_what_cannot_be(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    assert "--best has planets and views of its own" in fails([*COMMAND, "--view", "near", "-o", str(tmp_path)], capsys)
    (tmp_path / "earth-space.jpg").write_text("no picture")
    assert "cannot be read as a picture" in fails([*COMMAND, "-o", str(tmp_path)], capsys)
    with pytest.raises(pf.UnknownNameError):
        best_gallery(tmp_path / "b", pairs=[("earth", "vally")])
    assert not FakeRenderer.made
    with pytest.raises(CaptureError, match="takes u8 pixels"):
        write_jpeg(tmp_path / "x.jpg", np.zeros((4, 4), np.uint8))
