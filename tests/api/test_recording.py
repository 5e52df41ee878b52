"""Recordings: the same frames whether interrupted or not, and animated GIFs."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageSequence

import planetfall as pf
from planetfall.capture import recording
from planetfall.capture.recording import frames_to_render
from planetfall.systems.capture import CaptureError, write_gif


def test_every_missing_frame_has_the_frames_before_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recording, "PART", 4)
    monkeypatch.setattr(recording, "RUN_UP", 2)
    whole = list(frames_to_render(range(10)))
    assert whole[0] == (0, None) and [i for i, kept in whole if kept] == list(range(10))
    assert whole[5:9] == [(2, None), (2, False), (3, False), (4, True)]
    rest = list(frames_to_render([6, 9]))
    assert rest == [
        (2, None), (2, False), (3, False), (4, False), (5, False), (6, True),
        (6, None), (6, False), (7, False), (8, False), (9, True),
    ]  # fmt: skip
    assert list(frames_to_render([])) == []


@pytest.mark.gpu
def test_an_interrupted_recording_ends_with_the_same_frames(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recording, "PART", 3)
    monkeypatch.setattr(recording, "RUN_UP", 1)
    options = {"count": 5, "size": (64, 36), "quality": "low", "video": False, "gif": True}

    def hashes(folder: Path) -> list[str]:
        return [hashlib.sha256(np.asarray(Image.open(f)).tobytes()).hexdigest() for f in sorted(folder.glob("frame*"))]

    with pf.load_scene("earth") as scene:
        seen: list[tuple[int, int]] = []
        made = pf.record(scene, "low", tmp_path / "a", progress=lambda a, b: seen.append((a, b)), **options)
        assert seen == [(n, 5) for n in range(1, 6)]
        whole = hashes(made.folder)
        assert len(set(whole)) == 5
        for index in (1, 3, 4):
            made.frames[index].unlink()
        untouched = made.frames[2].stat().st_mtime_ns
        pf.record(scene, "low", tmp_path / "a", **options)
    assert hashes(made.folder) == whole and made.frames[2].stat().st_mtime_ns == untouched
    assert made.gif is not None and made.gif.stat().st_size > 0


@pytest.mark.parametrize("fps", [0.0, -1.0, float("nan"), float("inf"), "24"])
def test_a_rate_that_cannot_be_is_refused_before_any_frame(tmp_path: Path, fps: Any) -> None:
    with pf.load_scene("earth") as scene:
        with pytest.raises(pf.SettingError, match=r"record: fps: expected 0\.001 to 1000 frames a second, found"):
            pf.record(scene, "low", tmp_path / "a", fps=fps)
        with pytest.raises(pf.SettingError, match=r"fps: expected 0\.1 to 1000"):
            pf.record(scene, "low", tmp_path / "a", fps=0.05, gif=True)
    assert list(tmp_path.iterdir()) == []


def test_a_name_is_no_scene(tmp_path: Path) -> None:
    calls: dict[str, Any] = {
        "record": lambda: pf.record("earth", folder=tmp_path / "a"),  # type: ignore[arg-type]
        "path": lambda: pf.path("low", "earth"),  # type: ignore[arg-type]
        "photo": lambda: pf.photo("earth", pf.Camera.at(0, 0, 1e6)),  # type: ignore[arg-type]
        "Renderer": lambda: pf.Renderer("earth"),  # type: ignore[arg-type]
    }
    for name, call in calls.items():
        with pytest.raises(pf.SceneError, match=rf"{name}: expected a scene such as pf\.load_scene\('earth'\)"):
            call()
    assert list(tmp_path.iterdir()) == []


def test_a_flight_over_another_planet_is_said(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    file = tmp_path / "paths.toml"
    file.write_text('[path.any]\nkind = "cruise"\nlatitude_deg = 1\nlongitude_deg = 2\nheading_deg = 3\n'
                    'speed_m_s = 4\naltitude_m = 5\nduration_s = 6\n')  # fmt: skip
    with pf.load_scene("asteroid") as scene:
        pf.path("any", scene, file)
        assert caplog.records == []
        pf.path("descent", scene)
    (record,) = caplog.records
    assert "'descent' was made for earth: over asteroid" in record.getMessage()
    caplog.clear()
    with pf.load_scene("earth") as scene:
        pf.path("descent", scene)
    assert caplog.records == []


def test_gifs_show_what_they_were_given(tmp_path: Path) -> None:
    x = np.linspace(0, 255, 40).astype(np.uint8)
    frames = [np.stack([np.tile(x, (30, 1)), np.full((30, 40), 20 * n, np.uint8), np.tile(x[::-1], (30, 1))], 2)
              for n in range(8)]  # fmt: skip
    file = write_gif(tmp_path / "a.gif", frames, fps=20.0)
    with Image.open(file) as image:
        assert image.info["loop"] == 0 and image.info["duration"] == 50
        shown = [np.asarray(frame.convert("RGB")).astype(int) for frame in ImageSequence.Iterator(image)]
    assert len(shown) == 8
    for found, wanted in zip(shown, frames, strict=True):
        assert np.abs(found - wanted).mean() < 8.0  # 256 colours for all
    small = write_gif(tmp_path / "b.gif", frames, width=20)
    assert Image.open(small).size == (20, 15)
    for bad, said in (((tmp_path / "a.png", frames), ".gif"), ((tmp_path / "c.gif", []), "at least one")):
        with pytest.raises(CaptureError, match=said):
            write_gif(*bad)
    with pytest.raises(CaptureError, match=r"0\.1 to 50"):
        write_gif(tmp_path / "c.gif", frames, fps=100.0)


@pytest.mark.gpu
def test_parts_of_a_recording_are_put_together(tmp_path: Path) -> None:
    options = {"count": 4, "size": (64, 36), "quality": "low", "video": False}
    with pf.load_scene("moon") as scene:
        whole = pf.record(scene, "descent", tmp_path / "a", **options)
        seen: list[tuple[int, int]] = []
        second = pf.record(
            scene, "descent", tmp_path / "b", frames=[2, 3], progress=lambda a, b: seen.append((a, b)), **options
        )
        assert seen == [(1, 2), (2, 2)] and second.sheet is None and len(second.frames) == 2
        assert not (tmp_path / "b" / "contact_sheet.png").exists()
        first = pf.record(scene, "descent", tmp_path / "b", frames=[0, 1], **options)
    assert first.sheet is not None and first.sheet.is_file() and len(first.frames) == 4
    for one, two in zip(whole.frames, first.frames, strict=True):
        np.testing.assert_array_equal(np.asarray(Image.open(one)), np.asarray(Image.open(two)))


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"quality": "lwo"}, "did you mean 'low'"),
        ({"overrides": {"terrain.edge": 3.0}}, "terrain.edge"),
        ({"size": (0, 36)}, "at least 1"),
        ({"count": 0}, "at least 1"),
        ({"count": 2.5}, "whole number of frames"),
        ({"frames": [7]}, "from 0 to 2, found 7"),
    ],
)
def test_what_is_wrong_leaves_no_folder_that_refuses_the_next_try(tmp_path: Path, options: Any, match: str) -> None:
    with pf.load_scene("mars") as scene, pytest.raises(pf.expected_errors(), match=match):
        pf.record(scene, "low", tmp_path / "out", **{"count": 3, "video": False, **options})
    assert not (tmp_path / "out").exists()
