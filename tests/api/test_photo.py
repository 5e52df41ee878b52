"""Photos: tiles that meet, samples that are averaged in light, and settings that make the same picture again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import planetfall as pf
from planetfall.capture.photos import PhotoPlan, averaged
from planetfall.capture.shot import load_shot, shot_settings
from planetfall.cli.main import main
from planetfall.systems.capture import CaptureError, read_png_settings, write_png

STILL = {"composite.bloom": 0.0, "composite.dither": False}


@pytest.mark.parametrize(
    ("size", "samples", "tile_px", "count"),
    [((640, 360), 1, 2048, 1), ((3840, 2160), 1, 2048, 4), ((3840, 2160), 2, 2048, 16), ((1000, 10), 4, 256, 20)],
)
def test_tiles_cover_the_picture_once(size: tuple[int, int], samples: int, tile_px: int, count: int) -> None:
    plan = PhotoPlan(size, samples, tile_px)
    seen = np.zeros((size[1], size[0]), int)
    for left, top, right, bottom in plan.tiles():
        seen[top:bottom, left:right] += 1
        if len(plan.tiles()) > 1:  # with its margins it is no larger than asked for
            assert (max(right - left, bottom - top) + 2 * -(-32 // samples)) * samples <= tile_px
    assert (seen == 1).all() and abs(len(plan.tiles()) - count) <= count // 2


@pytest.mark.parametrize(
    "bad", [{"size": (0, 5)}, {"size": (70_000, 5)}, {"supersample": 9}, {"supersample": 2.5}, {"tile_px": 10}]
)
def test_plans_that_cannot_be(bad: dict) -> None:
    with pytest.raises(pf.SizeError, match=next(iter(bad))):
        PhotoPlan(**bad)


def test_samples_are_averaged_in_linear_light() -> None:
    black_and_white = np.zeros((4, 4, 3), np.uint8)
    black_and_white[::2, ::2] = black_and_white[1::2, 1::2] = 255
    # Half the light is 0.5 ** (1 / 2.4) * 1.055 - 0.055 = 0.7354 of the signal (IEC 61966-2-1).
    assert (averaged(black_and_white, 2) == 188).all()
    plain = np.arange(48, dtype=np.uint8).reshape(4, 4, 3)
    assert averaged(plain, 1) is plain
    assert np.array_equal(averaged(np.repeat(np.repeat(plain, 3, 0), 3, 1), 3), plain)


@pytest.mark.gpu
def test_tiles_meet_and_are_the_whole_picture() -> None:
    with pf.load_scene("earth") as scene:
        camera = pf.Camera.at(49.9, 112.3, 2000.0, heading_deg=30, pitch_deg=-12, above="ground")
        shared = {"quality": "low", "overrides": STILL, "ev100": 14.5}
        whole = pf.photo(scene, camera, (420, 120), **shared).astype(int)
        done: list[tuple[int, int]] = []
        tiles = pf.photo(
            scene, camera, (420, 120), tile_px=256, progress=lambda a, b: done.append((a, b)), **shared
        ).astype(int)
    assert done[0] == (0, 3) and done[-1] == (3, 3)
    away = np.abs(whole - tiles).max(axis=2)
    # Triangles are chosen by tiles of the picture, so a few hills have other edges; nowhere is a seam.
    assert away.mean() < 2.0
    edges = [left for left, *_ in PhotoPlan((420, 120), 1, 256).tiles() if left]
    steps = np.abs(np.diff(tiles, axis=1)).mean(axis=(0, 2))
    usual = np.abs(np.diff(whole, axis=1)).mean(axis=(0, 2))
    for edge in edges:
        assert steps[edge - 1] < 1.5 * usual[edge - 1] + 1.0


@pytest.mark.gpu
def test_a_picture_is_made_again_from_its_own_settings(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    first, again, larger = (tmp_path / f"{name}.png" for name in ("first", "again", "larger"))
    options = ["--latitude-deg", "49.9", "--longitude-deg", "112.3", "--altitude-m", "3000", "--pitch-deg", "-10"]
    assert main(["render", "earth", *options, "--sun-elevation-deg", "20", "--size", "96x54", "--quality", "low",
                 "--time-s", "7", "--set", "terrain.edge_px=20", "-o", str(first)]) == 0  # fmt: skip
    told = read_png_settings(first)
    assert told["exposure"] is not None and told["components"]["sun"]["elevation_deg"] == 20.0
    assert main(["render", "--like", str(first), "-o", str(again)]) == 0
    a, b = (np.asarray(Image.open(file)).astype(int) for file in (first, again))
    assert np.abs(a - b).max() <= 1 and (a != b).mean() < 0.01  # exposure was adapted there, and is fixed here
    assert main(["render", "--like", str(first), "--supersample", "2", "--size", "64x36", "-o", str(larger)]) == 0
    assert Image.open(larger).size == (64, 36) and read_png_settings(larger)["supersample"] == 2
    assert main(["render", "mars", "--like", str(first), "-o", str(again)]) == 2
    assert "brings its own planet" in capsys.readouterr().err


def test_a_shot_comes_back_whole(tmp_path: Path) -> None:
    with pf.load_scene("mars") as scene:
        scene.planet[pf.Terrain].seed = 77
        scene.add(pf.Shape("box"), pf.Transform(position_m=(0, 0, 4e6)), name="stone")
        camera = pf.Camera.at(5, 6, 7000.0, heading_deg=8, pitch_deg=-9, fov_y_deg=33.0)
        state = camera.resolve(scene, 2.0)
        settings = shot_settings(
            scene, state, 12.5, (200, 100), quality="low", overrides={"terrain.edge_px": 9.0}, ev100=11.0,
            sun=pf.Sun(epoch_s=5e5), supersample=3, mode="walk",
        )  # fmt: skip
    file = write_png(tmp_path / "a.png", np.zeros((2, 2, 3), np.uint8), settings)
    shot = load_shot(file)
    with shot.scene as again:
        assert again.planet[pf.Terrain].seed == 77 and again.sun.epoch_s == 5e5 and again.name == "mars"
        assert [prop.name for prop in again.props] == ["stone"]
        found = shot.camera.resolve(again, 2.0)
        for name in ("position_m", "forward", "up", "tan_top", "tan_left"):
            np.testing.assert_allclose(getattr(found, name), getattr(state, name), rtol=1e-14)
        assert (shot.time_s, shot.size, shot.quality, shot.supersample, shot.ev100, shot.mode) == (
            12.5, (200, 100), "low", 3, 11.0, "walk",
        )  # fmt: skip
        assert dict(shot.overrides) == {"terrain.edge_px": 9.0}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"components": None}, "damaged"),
        ({"components": {"terrain": {"seeed": 3}}}, "seeed"),
        ({"camera": {"position_m": [0, 0, 0]}}, "lack"),
        ({"size": "big"}, "big"),
        ({"scene": None, "camera": 3}, "damaged"),
    ],
)
def test_damaged_settings_are_errors_that_name_the_file(tmp_path: Path, change: dict, said: str) -> None:
    with pf.load_scene("moon") as scene:
        settings = shot_settings(scene, pf.Camera.at(1, 2, 3e5).resolve(scene), 0.0, (4, 4), quality="low")
    file = write_png(tmp_path / "a.png", np.zeros((2, 2, 3), np.uint8), settings | change)
    with pytest.raises((pf.PresetError, CaptureError), match=said) as error:
        load_shot(file)
    assert str(file) in str(error.value)
    older = write_png(tmp_path / "old.png", np.zeros((2, 2, 3), np.uint8), {"camera": {}, "planet": "earth"})
    with pytest.raises(CaptureError, match="older version"):
        load_shot(older)
