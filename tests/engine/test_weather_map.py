"""Weather from a file: what is shown is what the file says, all around, and it moves with the winds."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cloud_kit import cloudy, renderer_of
from PIL import Image

import planetfall as pf
from planetfall.components import Clouds
from planetfall.systems.clouds.imported import IMPORT_BORDER, imported_cover, octahedral_directions
from planetfall.systems.clouds.maps import BORDER
from planetfall.systems.clouds.ours import OurClouds

DAY_S = 86400.0


def cover_of(directions: np.ndarray) -> np.ndarray:
    """A smooth cover of the sphere that is nowhere alike, 0.05 .. 0.95; its axes have no part in it."""
    x, y, z = np.moveaxis(directions / np.linalg.norm(directions, axis=-1, keepdims=True), -1, 0)
    return 0.5 + 0.45 * np.sin(3.0 * x + 1.0) * np.cos(4.0 * y - 2.0 * z)


def plate(height: int) -> np.ndarray:
    """Equirectangular, north on top, -180 degrees at the left."""
    latitude = np.radians(90.0 - 180.0 * (np.arange(height) + 0.5) / height)[:, None]
    longitude = np.radians(-180.0 + 180.0 * (np.arange(2 * height) + 0.5) / height)[None, :]
    up = np.broadcast_to(np.sin(latitude), (height, 2 * height))
    east = np.cos(latitude)
    return cover_of(np.stack([east * np.cos(longitude), east * np.sin(longitude), up], axis=-1))


@pytest.fixture
def png(tmp_path: Path) -> Path:
    file = tmp_path / "cover.png"
    Image.fromarray(np.round(plate(128) * 65535).astype(np.uint16)).save(file)
    return file


def shown(renderer: pf.Renderer) -> np.ndarray:
    """Cover (side, side) of the first map that is shown, with its border."""
    system = renderer.system("clouds").method
    assert isinstance(system, OurClouds)
    with renderer.current():
        held = system.field.maps.shown[0]
        return np.frombuffer(held.read(), np.uint8).reshape(*held.size, 4)[..., 0] / 255.0


def test_the_cover_is_the_files_at_poles_and_date_line_too(png: Path) -> None:
    found = imported_cover(str(png))
    side = len(found) - 2 * IMPORT_BORDER
    wanted = cover_of(octahedral_directions(side, IMPORT_BORDER))
    # Cubic between samples 1.4 degrees apart, of a function with wavelengths of 60 degrees: 1e-4, and 16 bits.
    assert np.abs(found - wanted).max() < 1e-3


@pytest.mark.parametrize("ending", ["npy", "exr", "tif"])
def test_other_files_say_the_same(tmp_path: Path, png: Path, ending: str) -> None:
    file = tmp_path / f"cover.{ending}"
    values = plate(128).astype(np.float32)
    if ending == "npy":
        np.save(file, values)
    elif ending == "exr":
        exr = pytest.importorskip("OpenEXR")
        exr.File({"compression": exr.ZIP_COMPRESSION}, {"Y": values}).write(str(file))
    else:
        pytest.importorskip("tifffile").imwrite(file, values)
    np.testing.assert_allclose(imported_cover(str(file)), imported_cover(str(png)), atol=2e-5)


def test_the_map_on_the_gpu_is_the_file_and_drifts_with_the_wind(png: Path) -> None:
    camera = pf.Camera.at(0.0, 0.0, 1e7, pitch_deg=-90.0)
    scene = cloudy(weather_map=str(png), wind_speed_m_s=20.0, coverage=0.3)
    with renderer_of(scene) as renderer:
        renderer.render(camera)
        at_once = shown(renderer)
        wanted = cover_of(octahedral_directions(len(at_once) - 2 * BORDER, BORDER))
        # Eight bits, halves, and bilinear reads of samples 0.7 degrees apart; coverage doesn't count.
        assert np.abs(at_once - wanted).max() < 6e-3
        system = renderer.system("clouds").method
        assert isinstance(system, OurClouds)
        # The frame of the map turns eastwards with the wind: what was over longitude 0 is over 20 m/s x 12 h = 864 km.
        renderer.render(camera, time_s=0.5 * DAY_S)
        turn = np.asarray(system.field.block.turn)  # columns
        angle = 20.0 * 0.5 * DAY_S / 6.36e6
        np.testing.assert_allclose(turn[0, :2], [np.cos(angle), -np.sin(angle)], atol=1e-6)
        half_day = shown(renderer)
        renderer.render(camera, time_s=10.0 * DAY_S)
        days = shown(renderer)
    # Winds shear it along the parallels, each generation by its own; the mean of a parallel stays what it is.
    assert 0.9 < np.corrcoef(half_day.ravel(), at_once.ravel())[0, 1] < 0.9999
    assert days.mean() == pytest.approx(at_once.mean(), abs=0.03)


def _scene(folder: Path, path: str) -> Path:
    file = folder / "scene.toml"
    file.write_text(f'[planet]\nradius_m = 6.36e6\n[clouds]\nweather_map = "{path}"\n')
    return file


def test_paths_count_from_the_scenes_folder(tmp_path: Path, png: Path) -> None:
    scene = pf.load_scene(_scene(tmp_path, "cover.png"))
    assert scene.planet[Clouds].weather_map == str(png)
    again = tmp_path / "again.toml"
    scene.save(again)
    assert pf.load_scene(again).planet[Clouds].weather_map == str(png)


def bad_files(folder: Path, png: Path) -> dict[str, tuple[str, tuple[str, ...]]]:
    """What is wrong -> (path, words of the message)."""

    def save(name: str, array: Any) -> str:
        if name.endswith(".npy"):
            np.save(folder / name, array)
        else:
            Image.fromarray(array).save(folder / name)
        return str(folder / name)

    cut = folder / "cut.png"
    cut.write_bytes(png.read_bytes()[:3000])
    short = folder / "short.npy"
    np.save(short, plate(16))
    short.write_bytes(short.read_bytes()[:500])
    gap, beyond = plate(16), plate(16)
    gap[3, 5] = np.nan
    beyond[2, 9] = 1.5
    return {
        "missing": (str(folder / "none.png"), ("none.png", "no file")),
        "truncated": (str(cut), ("cut.png", "can't be read")),
        "truncated array": (str(short), ("short.npy", "can't be read")),
        "NaN": (save("nan.npy", gap), ("1 values that are no finite numbers", "column 5, row 3")),
        "beyond": (save("beyond.npy", beyond), ("1 values outside 0..1", "1.5", "column 9, row 2")),
        "aspect": (save("a.png", np.zeros((64, 100), np.uint8)), ("100 x 64", "twice as wide")),
        "transparency": (save("t.png", np.zeros((32, 64, 4), np.uint8)), ("4 channels", "transparency")),
        "whole numbers": (save("i.npy", np.zeros((32, 64), np.int32)), ("int32", "fractions")),
        "shape": (save("s.npy", np.zeros(64)), ("(64,)", "rows")),
        "ending": (save("h.bmp", np.zeros((32, 64), np.uint8)), ("h.bmp", "ending")),
    }


@pytest.mark.parametrize("what", [
    "missing", "truncated", "truncated array", "NaN", "beyond", "aspect", "transparency", "whole numbers", "shape",
    "ending",
])  # fmt: skip
def test_bad_files_say_what_where_and_what_to_do(tmp_path: Path, png: Path, what: str) -> None:
    path, words = bad_files(tmp_path, png)[what]
    with pytest.raises(pf.SettingError) as caught:
        pf.load_scene(_scene(tmp_path, path))
    for word in ("Clouds.weather_map", *words):
        assert word in str(caught.value), str(caught.value)


def test_a_broken_map_leaves_the_weather_as_it_was(tmp_path: Path, png: Path) -> None:
    scene = cloudy(weather_map=str(png))
    camera = pf.Camera.at(10.0, 20.0, 1e7, pitch_deg=-90.0)
    with renderer_of(scene) as renderer:
        renderer.settle(camera)
        before = renderer.render(camera)["color"]
        scene.planet[Clouds].weather_map = str(tmp_path / "gone.png")
        with pytest.raises(pf.SettingError, match=r"gone\.png"):
            renderer.render(camera)
        renderer.settle(camera)
        np.testing.assert_array_equal(renderer.render(camera)["color"], before)
        scene.planet[Clouds].weather_map = ""
        assert (renderer.render(camera)["color"] != before).any()
        scene.planet[Clouds].weather_map = str(png)
        renderer.settle(camera)
        np.testing.assert_array_equal(renderer.render(camera)["color"], before)
