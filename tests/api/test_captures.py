"""Files of pictures and arrays: PNG, EXR and npz from Python, the command line and the window."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from app_kit import app_of, press
from test_exr import read

import planetfall as pf
from planetfall.capture.captures import ARRAYS, check_arrays, exr_channels, read_settings
from planetfall.capture.photos import PhotoPlan, photo_tiles
from planetfall.capture.shot import load_shot
from planetfall.cli.main import main
from planetfall.engine.wavelengths import DISPLAY_NM
from planetfall.systems.capture import CaptureError, read_arrays

VIEW = ["moon", "--view", "near", "--quality", "low"]


def test_channels_are_named_by_custom() -> None:
    rng = np.random.default_rng(1)
    shape = (3, 4)
    arrays = {
        "color": np.full((*shape, 3), 188, np.uint8),
        "radiance": rng.random((*shape, 3)).astype(np.float32),
        "distance": np.full(shape, np.inf, np.float32),
        "normal": rng.random((*shape, 3)).astype(np.float32),
        "surface": np.full(shape, 2, np.uint8),
        "gbuffer.attributes": rng.random((*shape, 4)).astype(np.float16),
    }
    found = exr_channels(arrays)
    axes = {f"normal.{axis}" for axis in "XYZ"}
    more = {f"gbuffer.attributes.{letter}" for letter in "RGBA"}
    assert set(found) == {"R", "G", "B", "Z", "color.R", "color.G", "color.B", "surface"} | axes | more
    assert all(channel.dtype == np.float32 and channel.shape == shape for channel in found.values())
    np.testing.assert_array_equal(found["G"], arrays["radiance"][..., 1])
    np.testing.assert_array_equal(found["normal.Z"], arrays["normal"][..., 2])
    assert np.isinf(found["Z"]).all()
    # 188 of 255 is half the light (IEC 61966-2-1).
    np.testing.assert_allclose(found["color.R"], 0.5, atol=0.004)


@pytest.mark.gpu
def test_the_command_line_writes_exr_and_takes_it_back(tmp_path: Path) -> None:
    exr, npz = tmp_path / "a.exr", tmp_path / "b.npz"
    assert main(["render", *VIEW, "--size", "32x18", "-o", str(exr)]) == 0
    channels, attributes = read(exr)
    assert struct.unpack("<fff", attributes["wavelengths_nm"]) == DISPLAY_NM
    assert {"R", "G", "B", "Z", "position.X", "normal.Y", "surface", "color.B"} <= set(channels)
    assert channels["R"].shape == (18, 32) and channels["R"].max() > 0.0
    sky = channels["surface"] == 0
    assert np.isinf(channels["Z"][sky]).all() and np.isfinite(channels["Z"][~sky]).all()
    assert load_shot(exr).size == (32, 18)
    assert main(["render", "--like", str(exr), "-o", str(npz)]) == 0
    arrays, settings = read_arrays(npz)
    assert tuple(arrays["wavelengths_nm"]) == tuple(settings["wavelengths_nm"]) == DISPLAY_NM
    assert set(ARRAYS) <= set(arrays) and settings["scene"] == "moon" == read_settings(exr)["scene"]
    np.testing.assert_array_equal(arrays["distance"], channels["Z"])
    np.testing.assert_array_equal(arrays["radiance"][..., 2], channels["B"])


@pytest.mark.gpu
def test_labels_on_the_command_line(tmp_path: Path) -> None:
    npz, exr = tmp_path / "a.npz", tmp_path / "a.exr"
    names = "depth, slope_deg,sunlit,albedo,material,instance"
    assert main(["render", *VIEW, "--size", "300x40", "--outputs", names, "-o", str(npz)]) == 0
    arrays, settings = read_arrays(npz)
    assert {"depth", "slope_deg", "sunlit", "albedo", "material", "instance"} <= set(arrays)
    assert "color" not in arrays and settings["materials"]["1"] == "water"
    # In tiles, and as an EXR, and what a picture was made of.
    tiled = ["--tile-px", "256", "--outputs", "depth,material"]
    assert main(["render", "--like", str(npz), *tiled, "-o", str(exr)]) == 0
    channels, _ = read(exr)
    assert set(channels) == {"depth", "material"}
    there = np.isfinite(arrays["depth"])
    near = np.abs(channels["depth"][there] / arrays["depth"][there] - 1.0) < 0.01
    assert near.mean() > 0.95 and channels["material"].shape == (40, 300)


@pytest.mark.parametrize(
    ("file", "names", "match"),
    [
        ("a.npz", "dpeth", "did you mean 'depth'"),
        ("a.npz", "depth,flow", "a single picture has none"),
        ("a.png", "depth", "a PNG takes color alone"),
        ("a.exr", "instance", "write a .npz"),
    ],
)
def test_outputs_that_cannot_be_are_told_at_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], file: str, names: str, match: str
) -> None:
    assert main(["render", "moon", "--outputs", names, "-o", str(tmp_path / file)]) == 2
    assert match in capsys.readouterr().err.replace("\n", " ") and not (tmp_path / file).exists()


@pytest.mark.gpu
def test_arrays_of_tiles_and_of_several_samples() -> None:
    with pf.load_scene("moon") as scene, pf.Renderer(scene, (64, 64), "low") as renderer:
        camera = pf.view("near")
        fixed = camera.ev100 or 14.0

        def taken(size: tuple[int, int], samples: int, tile_px: int = 2048) -> dict[str, np.ndarray]:
            plan = PhotoPlan(size, samples, tile_px, fixed)
            return list(photo_tiles(renderer, camera, plan, outputs=ARRAYS))[-1][2]

        fine, coarse = taken((96, 48), 1), taken((48, 24), 2)
        # Twice the pixels of half the size are the very same samples.
        light = fine["radiance"].astype(float).reshape(24, 2, 48, 2, 3).mean(axis=(1, 3))
        np.testing.assert_allclose(coarse["radiance"], light, rtol=1e-5)
        np.testing.assert_array_equal(coarse["distance"], fine["distance"][1::2, 1::2])
        tiles = taken((300, 40), 1, 256)
        assert {name: values.shape[:2] for name, values in tiles.items()} == dict.fromkeys(ARRAYS, (40, 300))
        # Grids differ a little from tile to tile of the picture (they have other sizes): places are the same ground.
        whole = taken((300, 40), 1)
        ground = np.isfinite(whole["distance"]) & np.isfinite(tiles["distance"])
        off = np.abs(tiles["distance"][ground] / whole["distance"][ground] - 1.0)
        assert ground.mean() > 0.3 and np.median(off) < 1e-3


def test_the_window_writes_them_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PLANETFALL_CONFIG", str(tmp_path / "settings"))
    monkeypatch.chdir(tmp_path)
    with pf.load_scene("earth") as scene:
        scene.planet.remove(pf.Terrain)
        app, window, renderer = app_of(scene, camera=pf.Camera.at(0, 0, 1e6))
        asked = []

        def render(camera, time_s, sun=None, outputs=("color",), dt_s=None):
            asked.append(outputs)
            return {name: np.ones((36, 64, 3) if name != "distance" else (36, 64), np.uint8) for name in outputs}

        renderer.render = render
        press(window, "f10")
        app.frame()
        (file,) = tmp_path.glob("*.exr")
        assert asked == [ARRAYS] and str(file) in app.shown.message
        assert load_shot(file).scene.name == "earth"
        app.save_picture(tmp_path, ".npz")
        assert len(list(tmp_path.glob("*.npz"))) == 1
        app.journey.photo, app.journey.photo_suffix = PhotoPlan((65536, 65536)), ".exr"
        app.journey.start_photo()
        assert not app.photographing and "at most 64 million pixels" in app.shown.message


def test_files_that_cannot_be(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(pf.OutputError, match=r"\.png, \.exr or \.npz, found"):
        pf.save_capture(tmp_path / "a.tiff", {})
    with pytest.raises(pf.OutputError, match="takes the array 'color', found distance"):
        pf.save_capture(tmp_path / "a.png", {"distance": np.zeros((2, 2))})
    check_arrays(Path("a.png"), (60_000, 60_000))
    with pytest.raises(pf.OutputError, match=r"147\.5 GiB"):
        check_arrays(Path("a.npz"), (60_000, 60_000))
    assert main(["render", *VIEW, "--size", "60000x60000", "-o", str(tmp_path / "a.exr")]) == 2
    assert "million pixels" in capsys.readouterr().err
    for name, data in (("no.exr", b"PNG"), ("cut.exr", b"\x76\x2f\x31\x01\x02\0\0\0chan"), ("none.exr", None)):
        file = tmp_path / name
        if data is not None:
            file.write_bytes(data)
        with pytest.raises(CaptureError, match=name):
            read_settings(file)
    plain = pf.save_capture(tmp_path / "plain.exr", {"distance": np.zeros((2, 2), np.float32)})
    with pytest.raises(CaptureError, match="no Planetfall settings"):
        read_settings(plain)
